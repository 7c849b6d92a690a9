#include "perception/model/model_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/cloud/projector.h"
#include "scenes/base/error.h"
#include "scenes/geometry/sphere_directions.h"

namespace pickbed::perception {
namespace {

constexpr int kCandidates = 4;          // random samples per selected point
constexpr int kRasterSize = 128;        // pixels across the object in the visibility test
constexpr float kMinFacingCos = 0.15f;  // steeper points give no usable depth in any camera
constexpr int kFieldSamples = 20000;    // spacing of about 1 mm on an object of 10 cm
constexpr int kFieldNodes = 48;
constexpr double kFieldPadding_m = 0.015;  // covers the widest distance band of verification

// Orthographic z-buffer: maximum height of the surface along one direction.
class HeightRaster {
 public:
  HeightRaster(const Eigen::Vector3f& direction, const Eigen::Vector3f& center, float radius)
      : center_(center), pixel_m_(2.02f * radius / kRasterSize) {
    axes_.row(2) = direction;
    axes_.row(0) = direction.unitOrthogonal();
    axes_.row(1) = direction.cross(axes_.row(0).transpose());
    height_.assign(kRasterSize * kRasterSize, -std::numeric_limits<float>::max());
  }

  // Returns pixel coordinates (pixel centers at whole numbers) and the height in metres.
  Eigen::Vector3f ToRaster(const Eigen::Vector3f& p_O) const {
    Eigen::Vector3f r = axes_ * (p_O - center_);
    r.head<2>() = (r.head<2>() / pixel_m_).array() + 0.5f * (kRasterSize - 1);
    return r;
  }

  void Draw(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    const Eigen::Vector3f ab = b - a, ac = c - a;
    const float area = ab.x() * ac.y() - ab.y() * ac.x();
    if (std::abs(area) < 1e-9f) return;  // edge on
    // Slopes of the height per pixel.
    const float hx = (ab.z() * ac.y() - ac.z() * ab.y()) / area;
    const float hy = (ac.z() * ab.x() - ab.z() * ac.x()) / area;
    const int y0 = std::max(0, Ceil(std::min({a.y(), b.y(), c.y()})));
    const int y1 = std::min(kRasterSize - 1, Floor(std::max({a.y(), b.y(), c.y()})));
    for (int y = y0; y <= y1; ++y) {
      float left = std::numeric_limits<float>::max(), right = -left;
      Clip(a, b, static_cast<float>(y), left, right);
      Clip(b, c, static_cast<float>(y), left, right);
      Clip(c, a, static_cast<float>(y), left, right);
      const int x0 = std::max(0, Ceil(left)), x1 = std::min(kRasterSize - 1, Floor(right));
      float* row = height_.data() + y * kRasterSize;
      for (int x = x0; x <= x1; ++x) {
        row[x] = std::max(row[x], a.z() + hx * (static_cast<float>(x) - a.x()) +
                                      hy * (static_cast<float>(y) - a.y()));
      }
    }
  }

  // Whether nothing is above a surface point. `facing_cos` is the cosine between its normal and the
  // direction.
  bool Sees(const Eigen::Vector3f& p_O, float facing_cos) const {
    const Eigen::Vector3f r = ToRaster(p_O);
    const int x = std::clamp(static_cast<int>(std::lround(r.x())), 0, kRasterSize - 1);
    const int y = std::clamp(static_cast<int>(std::lround(r.y())), 0, kRasterSize - 1);
    // The nearest pixel center is up to half a pixel diagonal away. There the point's own surface
    // can be higher by its slope. A tenth of a pixel is added for rounding.
    const float slope = std::sqrt(1 - facing_cos * facing_cos) / facing_cos;
    return height_[y * kRasterSize + x] <= r.z() + pixel_m_ * (0.71f * slope + 0.1f);
  }

 private:
  static int Ceil(float v) { return static_cast<int>(std::ceil(v)); }
  static int Floor(float v) { return static_cast<int>(std::floor(v)); }

  // Extends [left, right] to the crossing of the edge and scan line y.
  static void Clip(const Eigen::Vector3f& a, const Eigen::Vector3f& b, float y, float& left,
                   float& right) {
    if ((a.y() > y && b.y() > y) || (a.y() < y && b.y() < y) || a.y() == b.y()) return;
    const float x = a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y());
    left = std::min(left, x);
    right = std::max(right, x);
  }

  Eigen::Matrix3f axes_;
  Eigen::Vector3f center_;
  float pixel_m_;
  std::vector<float> height_;
};

std::vector<uint16_t> VisiblePoints(const ModelPoints& points, const TriangleMesh& mesh,
                                    const std::vector<Eigen::Vector3f>& vertices,
                                    const Eigen::Vector3f& direction) {
  HeightRaster raster(direction, points.center_O, points.radius_m);
  std::vector<Eigen::Vector3f> projected(vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) projected[i] = raster.ToRaster(vertices[i]);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    raster.Draw(projected[t.x()], projected[t.y()], projected[t.z()]);
  }
  std::vector<uint16_t> visible;
  for (size_t i = 0; i < points.points_O.size(); ++i) {
    const float facing = points.normals_O[i].dot(direction);
    if (facing > kMinFacingCos && raster.Sees(points.points_O[i], facing)) {
      visible.push_back(static_cast<uint16_t>(i));
    }
  }
  return visible;
}

// Progressive Poisson-disk sampling (McCool and Fiume 1992). Takes candidates that keep a minimum
// distance to all taken ones, then shrinks the distance, until `count` are taken. The first n of
// the result cover the surface evenly for every n. A unit normal is scaled to a twentieth of the
// diameter, which separates the two sides of a thin wall.
std::vector<int> EvenOrder(const SurfaceSamples& candidates, int count, double diameter_m) {
  constexpr double kShrink = 0.85;
  const auto n = static_cast<int>(candidates.points.size());
  const float normal_m = static_cast<float>(0.05 * diameter_m);
  std::vector<Eigen::Matrix<float, 6, 1>> places(n);
  for (int i = 0; i < n; ++i) {
    places[i] << candidates.points[i].cast<float>(), normal_m * candidates.normals[i].cast<float>();
  }
  std::vector<float> squared_gap(n, std::numeric_limits<float>::max());
  std::vector<int> taken;
  const auto take = [&](int index) {
    taken.push_back(index);
    for (int i = 0; i < n; ++i) {
      squared_gap[i] = std::min(squared_gap[i], (places[i] - places[index]).squaredNorm());
    }
    squared_gap[index] = -1;
  };
  for (double gap = 0.5 * diameter_m; static_cast<int>(taken.size()) < count; gap *= kShrink) {
    const auto squared = static_cast<float>(gap * gap);  // reaches 0, so the loop ends
    for (int i = 0; i < n && static_cast<int>(taken.size()) < count; ++i) {
      if (squared_gap[i] >= squared) take(i);
    }
  }
  return taken;
}

DistanceField SurfaceDistance(const TriangleMesh& mesh, Rng& rng) {
  const SurfaceSamples dense = SampleSurface(mesh, kFieldSamples, rng);
  std::vector<Eigen::Vector3f> samples;
  samples.reserve(dense.points.size());
  for (const Eigen::Vector3d& p : dense.points) samples.push_back(p.cast<float>());
  return MakeDistanceField(samples, kFieldPadding_m, kFieldNodes);
}

}  // namespace

const std::vector<uint16_t>& ModelPoints::VisibleFrom(const Pose& X_CO) const {
  const Eigen::Vector3d center_C = X_CO * center_O.cast<double>();
  const Eigen::Vector3f to_camera_O = (X_CO.linear().transpose() * -center_C).cast<float>();
  size_t best = 0;
  float best_dot = -std::numeric_limits<float>::max();
  for (size_t i = 0; i < directions_O.size(); ++i) {
    const float dot = directions_O[i].dot(to_camera_O);
    if (dot > best_dot) {
      best_dot = dot;
      best = i;
    }
  }
  return visible[best];
}

ModelPoints MakeModelPoints(const ObjectModel& model, int points, int directions) {
  CheckInput(points >= 1 && points <= std::numeric_limits<uint16_t>::max() && directions >= 1,
             fmt::format("{} model points seen from {} directions: use 1..65535 points and at "
                         "least one direction",
                         points, directions));
  const double area = SurfaceArea(model.mesh_O);
  CheckInput(area > 0, fmt::format("the mesh of '{}' has no area: give a mesh with proper faces",
                                   model.name));
  ModelPoints result;
  Rng rng = Rng::Derive(model.mesh_hash, 0, "perception/model_points");
  const double diameter_m = model.diameter_m > 0 ? model.diameter_m : Diameter(model.mesh_O);
  result.diameter_m = static_cast<float>(diameter_m);
  const SurfaceSamples samples = SampleSurface(model.mesh_O, kCandidates * points, rng);
  SurfaceSamples even;
  for (const int i : EvenOrder(samples, points, diameter_m)) {
    even.points.push_back(samples.points[i]);
    even.triangles.push_back(samples.triangles[i]);
    result.points_O.push_back(samples.points[i].cast<float>());
    result.normals_O.push_back(samples.normals[i].cast<float>());
  }
  result.texture = MakeSurfaceTexture(model, even.points, even.triangles);
  result.edges = MakeEdgePoints(model.mesh_O);
  result.area_per_point_m2 = static_cast<float>(area / points);
  result.center_O = MeshBounds(model.mesh_O).center().cast<float>();
  std::vector<Eigen::Vector3f> vertices;
  for (const Eigen::Vector3d& v : model.mesh_O.vertices) {
    vertices.push_back(v.cast<float>());
    result.radius_m = std::max(result.radius_m, (vertices.back() - result.center_O).norm());
  }
  result.distance = SurfaceDistance(model.mesh_O, rng);
  for (const Eigen::Vector3d& direction_O : SphereDirections(directions)) {
    result.directions_O.push_back(direction_O.cast<float>());
  }
  for (const Eigen::Vector3f& d : result.directions_O) {
    result.visible.push_back(VisiblePoints(result, model.mesh_O, vertices, d));
  }
  return result;
}

std::vector<SeenPoint> SeenPoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                  const Pose& X_CO) {
  constexpr size_t kMaxPoints = 400;
  // Maximum distance of point and reading along the normal, up to 1 m; grows with z^2 beyond.
  constexpr float kSeen_m = 0.004f;
  constexpr float kMinFacingCos = 0.35f;  // at steeper angles a pixel covers much of the surface
  const Projector project(cloud.intrinsics);
  const Eigen::Isometry3f X = X_CO.cast<float>();
  const float z_m = (X * model.center_O).z();
  const float seen_m = kSeen_m * std::max(1.0f, z_m * z_m);
  std::vector<SeenPoint> seen;
  for (const uint16_t index : model.VisibleFrom(X_CO)) {
    if (seen.size() == kMaxPoints) break;
    const Eigen::Vector3f p = X * model.points_O[index];
    const Eigen::Vector3f n = X.linear() * model.normals_O[index];
    if (-n.dot(p.normalized()) < kMinFacingCos) continue;
    const int pixel = project(p);
    if (pixel < 0 || !(cloud.depth_m.data()[pixel] > 0)) continue;
    if (std::abs(n.dot(cloud.points_C[pixel] - p)) > seen_m) continue;
    seen.push_back({index, pixel});
  }
  return seen;
}

}  // namespace pickbed::perception
