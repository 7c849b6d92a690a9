#include "sim/drop/room.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "scenes/base/random.h"
#include "scenes/shape_families/mesh_cache.h"
#include "scenes/shape_families/sampled_names.h"
#include "sim/convex/convex_hull.h"
#include "sim/drop/distractors.h"

namespace pickbed::sim {
namespace {

constexpr double kThickness_m = 0.02;  // of ground and table tops

TriangleMesh HullMesh(const std::vector<Eigen::Vector3d>& points) {
  const ConvexHull hull = MakeConvexHull(points);
  TriangleMesh mesh;
  mesh.vertices = hull.vertices;
  mesh.triangles = hull.triangles;
  return mesh;
}

// A box with its upper side at z = 0.
TriangleMesh Plank(double length_m, double width_m, double thickness_m) {
  std::vector<Eigen::Vector3d> corners;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-1.0, 0.0}) {
        corners.emplace_back(x * length_m, y * width_m, z * thickness_m);
      }
    }
  }
  return HullMesh(corners);
}

TriangleMesh Cone(double bottom_m, double top_m, double height_m) {
  constexpr int kSides = 24;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    const Eigen::Vector3d side(std::cos(angle), std::sin(angle), 0);
    points.push_back(bottom_m * side);
    points.push_back(top_m * side + height_m * Eigen::Vector3d::UnitZ());
  }
  return HullMesh(points);
}

Pose RandomYaw(Rng& rng) {
  const double yaw = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  return Pose(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

// A rotation that puts one side of the shape's box down, or, for some shapes, any rotation.
Pose RandomRest(Rng& rng) {
  constexpr double kTilted = 0.2;
  if (rng.Uniform() < kTilted) return MakePose(rng.Rotation().toRotationMatrix(), {0, 0, 0});
  const double quarter = std::numbers::pi / 2;
  const Pose about_x(Eigen::AngleAxisd(quarter * rng.Index(4), Eigen::Vector3d::UnitX()));
  const Pose about_y(Eigen::AngleAxisd(quarter * rng.Index(2), Eigen::Vector3d::UnitY()));
  return RandomYaw(rng) * about_x * about_y;
}

// Distance of a point from the line between two points.
double FromLine(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double share = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - share * along).norm();
}

bool IsFree(const RoomBall& ball, const RoomCell& cell) {
  const double margin_m = 0.1 * cell.cell_m;
  if ((ball.center_B - cell.eye_B).norm() < ball.radius_m + margin_m) return false;
  if (FromLine(ball.center_B, cell.eye_B, Eigen::Vector3d::Zero()) < ball.radius_m) return false;
  return std::none_of(cell.kept_free.begin(), cell.kept_free.end(), [&](const RoomBall& kept) {
    return (kept.center_B - ball.center_B).norm() < kept.radius_m + ball.radius_m;
  });
}

}  // namespace

std::vector<const TriangleMesh*> RoomShapes::All() const {
  std::vector<const TriangleMesh*> all{&ground};
  for (const TriangleMesh& mesh : table_tops) all.push_back(&mesh);
  for (const TriangleMesh& mesh : things) all.push_back(&mesh);
  return all;
}

RoomShapes MakeRoomShapes(const ObjectSet& objects, double cell_m, uint64_t seed) {
  constexpr int kTables = 4, kBoxes = 12, kCones = 8, kSampled = 12;
  RoomShapes shapes;
  Rng rng = Rng::Derive(seed, 0, "room shapes");
  shapes.ground = Plank(12 * cell_m, 12 * cell_m, kThickness_m);
  for (int i = 0; i < kTables; ++i) {
    shapes.table_tops.push_back(
        Plank(cell_m * rng.Uniform(1.2, 4), cell_m * rng.Uniform(1, 2.5), kThickness_m));
  }
  const auto diameter_m = [&](double low, double high) {
    const auto& object = objects[rng.Index(static_cast<int>(objects.size()))];
    return object->diameter_m * std::exp(rng.Uniform(std::log(low), std::log(high)));
  };
  for (int i = 0; i < kBoxes; ++i) {
    shapes.things.push_back(Plank(diameter_m(0.4, 4), diameter_m(0.4, 4), diameter_m(0.15, 3)));
  }
  for (int i = 0; i < kCones; ++i) {
    const double radius_m = diameter_m(0.15, 1.2);
    shapes.things.push_back(Cone(radius_m, radius_m * rng.Uniform(0.6, 1.4), diameter_m(0.3, 4)));
  }
  DistractorOptions hulls;
  hulls.seed = seed;
  hulls.diameter_max = 2;
  for (const auto& hull : MakeDistractors({objects.front(), objects.back()}, hulls)) {
    shapes.things.push_back(hull->mesh_O);
  }
  for (int i = 0; i < kSampled; ++i) {
    const SampledShape sampled =
        SampleShapeOf(i % 2 == 0 ? "machine" : "supermarket", "seen", rng.Index(1000));
    const TriangleMesh mesh = CachedMeshOfSolid(sampled.solid);
    shapes.things.push_back(Scaled(mesh, diameter_m(0.5, 3) / Diameter(mesh)));
  }
  return shapes;
}

std::vector<PlacedShape> PlaceRoom(const RoomShapes& shapes, const RoomCell& cell, Rng& rng) {
  constexpr double kNothing = 0.1, kTable = 0.5;  // shares of rooms; the others have a floor
  constexpr int kMaxWalls = 3, kMinThings = 3, kMaxThings = 24, kAttempts = 8;
  std::vector<PlacedShape> placed;
  const double size = cell.cell_m;
  const int tables = static_cast<int>(shapes.table_tops.size());
  const double kind = rng.Uniform();
  if (kind < kNothing) return placed;
  double ground_m = cell.support_m;
  if (kind < kNothing + kTable) {
    const double shift_m = 0.25 * size;
    const Eigen::Vector3d center(rng.Uniform(-shift_m, shift_m), rng.Uniform(-shift_m, shift_m),
                                 cell.support_m);
    placed.push_back({1 + rng.Index(tables), Eigen::Translation3d(center) * RandomYaw(rng)});
    ground_m -= size * rng.Uniform(0.3, 1.5);
  }
  placed.push_back({0, Eigen::Translation3d(0, 0, ground_m) * RandomYaw(rng)});
  // The upper side of the ground is turned to the cell.
  for (int i = rng.Index(kMaxWalls + 1); i > 0; --i) {
    const Pose yaw = RandomYaw(rng);
    const Eigen::Vector3d inwards = yaw.linear().col(0);
    const double distance_m = size * rng.Uniform(0.6, 2.5);
    if (inwards.dot(cell.eye_B) + distance_m < 0.15 * size) continue;
    const Pose upright(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()));
    placed.push_back({0, Eigen::Translation3d(-distance_m * inwards) * yaw * upright});
  }
  const int count = kMinThings + rng.Index(kMaxThings - kMinThings + 1);
  for (int i = 0; i < count; ++i) {
    const int thing = rng.Index(static_cast<int>(shapes.things.size()));
    const TriangleMesh& mesh = shapes.things[thing];
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Pose rest = RandomRest(rng);
      const Bounds bounds = MeshBounds(Transformed(mesh, rest));
      const double angle = rng.Uniform(-std::numbers::pi, std::numbers::pi);
      const double radius_m = 1.5 * size * std::sqrt(rng.Uniform());
      const Eigen::Vector3d place(radius_m * std::cos(angle), radius_m * std::sin(angle),
                                  cell.support_m - bounds.min.z());
      const RoomBall ball{place + bounds.center(), 0.5 * bounds.size().norm()};
      if (!IsFree(ball, cell)) continue;
      placed.push_back({1 + tables + thing, Eigen::Translation3d(place) * rest});
      break;
    }
  }
  return placed;
}

}  // namespace pickbed::sim
