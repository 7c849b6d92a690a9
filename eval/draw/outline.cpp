#include "eval/draw/outline.h"

#include <array>
#include <cmath>

#include "scenes/geometry/pose.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::eval {
namespace {

constexpr double kCreaseCos = 0.8;  // edges of flatter folds are not drawn
constexpr double kNearPlane_m = 0.02;

using PlaceKey = std::array<int64_t, 3>;

PlaceKey KeyOf(const Eigen::Vector3d& p) {
  constexpr double kGrid_m = 1e-6;  // merges vertices that are split because of their normals
  return {std::llround(p.x() / kGrid_m), std::llround(p.y() / kGrid_m),
          std::llround(p.z() / kGrid_m)};
}

}  // namespace

std::vector<ObjectOutlines::Edge> ObjectOutlines::EdgesOf(const TriangleMesh& mesh) {
  const std::vector<Eigen::Vector3d> normals = FaceNormals(mesh);
  std::map<std::pair<PlaceKey, PlaceKey>, Edge> edges;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = mesh.vertices[mesh.triangles[t][k]];
      const Eigen::Vector3d& b = mesh.vertices[mesh.triangles[t][(k + 1) % 3]];
      const PlaceKey ka = KeyOf(a), kb = KeyOf(b);
      auto [it, is_new] = edges.try_emplace(std::minmax(ka, kb));
      if (is_new)
        it->second = {a, b, normals[t], -normals[t]};
      else
        it->second.normal_2_O = normals[t];
    }
  }
  std::vector<Edge> list;
  list.reserve(edges.size());
  for (const auto& [key, edge] : edges) list.push_back(edge);
  return list;
}

std::vector<PixelLine> ObjectOutlines::At(ObjectId object, const Pose& X_CO,
                                          const CameraIntrinsics& camera) {
  auto [edges, is_new] = edges_.try_emplace(object);
  if (is_new) edges->second = EdgesOf(objects_.at(object)->mesh_O);
  const Eigen::Vector3d camera_O = X_CO.inverse().translation();
  std::vector<PixelLine> lines;
  for (const Edge& edge : edges->second) {
    const Eigen::Vector3d to_camera = camera_O - edge.a_O;
    const bool faces_1 = edge.normal_1_O.dot(to_camera) > 0;
    const bool faces_2 = edge.normal_2_O.dot(to_camera) > 0;
    const bool silhouette = faces_1 != faces_2;
    const bool crease = faces_1 && faces_2 && edge.normal_1_O.dot(edge.normal_2_O) < kCreaseCos;
    if (!silhouette && !crease) continue;
    const Eigen::Vector3d a_C = X_CO * edge.a_O, b_C = X_CO * edge.b_O;
    if (a_C.z() < kNearPlane_m || b_C.z() < kNearPlane_m) continue;
    lines.push_back({Project(camera, a_C), Project(camera, b_C)});
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

}  // namespace pickbed::eval
