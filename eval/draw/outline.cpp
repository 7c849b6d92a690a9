#include "eval/draw/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "eval/draw/silhouettes.h"
#include "scenes/camera/footprint.h"
#include "scenes/geometry/pose.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::eval {
namespace {

constexpr double kCreaseCos = 0.8;      // edges of flatter folds are not drawn
constexpr double kTieDiameters = 0.01;  // a line this far behind the surface is on it

// Appends the parts of an edge that the surfaces in `map` do not hide.
void AddVisible(const RegionMap& map, const CameraIntrinsics& camera, const Eigen::Vector3d& a_C,
                const Eigen::Vector3d& b_C, double tie_m, std::vector<PixelLine>& lines) {
  if (std::min(a_C.z(), b_C.z()) < kNearestDrawn_m) return;
  const Eigen::Vector2d a = Project(camera, a_C), b = Project(camera, b_C);
  const int steps = std::clamp(static_cast<int>(std::ceil((b - a).norm())), 1, 4096);
  bool drawing = false;
  for (int i = 0; i < steps; ++i) {
    const double at = (i + 0.5) / steps;
    const Eigen::Vector2d p = a + (b - a) * at;
    // Inverse depth is linear in the image.
    const double z_m = 1 / ((1 - at) / a_C.z() + at / b_C.z());
    if (!map.Sees(p, z_m - tie_m)) {
      drawing = false;
      continue;
    }
    const Eigen::Vector2d end = a + (b - a) * ((i + 1.0) / steps);
    if (drawing) {
      lines.back().b = end;
    } else {
      lines.push_back({a + (b - a) * (static_cast<double>(i) / steps), end});
    }
    drawing = true;
  }
}

}  // namespace

std::vector<PixelLine> ObjectOutlines::At(ObjectId object, const Pose& X_CO,
                                          const CameraIntrinsics& camera) {
  const ObjectModel& model = *objects_.at(object);
  auto drawn = drawn_.find(object);
  if (drawn == drawn_.end()) {
    drawn = drawn_.emplace(object, Drawn{MeshEdges(model.mesh_O), RasterMesh(model.mesh_O)}).first;
  }
  RegionMap map(camera, 1);
  map.Add(drawn->second.mesh, X_CO);
  const double tie_m = kTieDiameters * model.diameter_m;
  const Eigen::Vector3d camera_O = X_CO.inverse().translation();
  std::vector<PixelLine> lines;
  for (const MeshEdge& edge : drawn->second.edges) {
    const Eigen::Vector3d to_camera = camera_O - edge.a;
    const bool faces_1 = edge.normal_1.dot(to_camera) > 0;
    const bool faces_2 = edge.normal_2.dot(to_camera) > 0;
    const bool silhouette = faces_1 != faces_2;
    const bool crease = faces_1 && faces_2 && edge.normal_cos() < kCreaseCos;
    if (!silhouette && !crease) continue;
    AddVisible(map, camera, X_CO * edge.a, X_CO * edge.b, tie_m, lines);
  }
  return lines;
}

Camera CameraTowards(const Eigen::Vector3d& target, const Eigen::Vector3d& from, double distance_m,
                     int width_px, int height_px, double focal_px) {
  constexpr double kAlongZ = 0.99;
  Camera camera;
  camera.intrinsics = {
      width_px, height_px, focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1)};
  const Eigen::Vector3d direction = from.normalized();
  const Eigen::Vector3d up =
      std::abs(direction.z()) > kAlongZ ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  camera.SetPose(LookAt(target + distance_m * direction, target, up));
  return camera;
}

Camera CameraAround(const std::vector<Eigen::Vector3d>& points_W, const Eigen::Vector3d& from,
                    double margin, int width_px, int height_px, double focal_px) {
  const auto towards = [&](const Eigen::Vector3d& target_W, double distance_m) {
    return CameraTowards(target_W, from, distance_m, width_px, height_px, focal_px);
  };
  const Pose X_CW = towards(Eigen::Vector3d::Zero(), 1).X_CW();
  // A camera moved by (x, y, z) sees the point p if |p.x - x| <= slope.x * (p.z - z), the same for
  // y. The largest sums below bound x - slope * z from below and x + slope * z from above.
  const Eigen::Array2d slope = (0.5 - margin) * Eigen::Array2d(width_px, height_px) / focal_px;
  Eigen::Array2d right = Eigen::Array2d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Array2d left = right;
  for (const Eigen::Vector3d& p_W : points_W) {
    const Eigen::Vector3d p_C = X_CW * p_W;
    right = right.max(p_C.head<2>().array() - slope * p_C.z());
    left = left.max(-p_C.head<2>().array() - slope * p_C.z());
  }
  const double distance_m = 1 + (0.5 * (right + left) / slope).maxCoeff();
  if (!(distance_m > 1e-9)) throw std::logic_error("no two different points to look at");
  const Eigen::Array2d center = 0.5 * (right - left);
  return towards(X_CW.inverse() * Eigen::Vector3d(center.x(), center.y(), 1), distance_m);
}

TriangleMesh BoxesMesh(const std::vector<AxisAlignedBox>& boxes) {
  TriangleMesh mesh;
  for (const AxisAlignedBox& box : boxes) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      mesh.vertices.push_back(box.center + sign.cwiseProduct(box.half_size));
    }
    for (const Eigen::Vector3i& t : {Eigen::Vector3i{0, 2, 1},
                                     {1, 2, 3},
                                     {4, 5, 6},
                                     {5, 7, 6},
                                     {0, 1, 4},
                                     {1, 5, 4},
                                     {2, 6, 3},
                                     {3, 6, 7},
                                     {0, 4, 2},
                                     {2, 4, 6},
                                     {1, 3, 5},
                                     {3, 7, 5}}) {
      mesh.triangles.push_back(t.array() + first);
    }
  }
  return mesh;
}

}  // namespace pickbed::eval
