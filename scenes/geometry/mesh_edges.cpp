#include "scenes/geometry/mesh_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace pickbed::scenes {
namespace {

using PlaceKey = std::array<int64_t, 3>;

PlaceKey KeyOf(const Eigen::Vector3d& p) {
  constexpr double kGrid_m = 1e-6;  // merges vertices that are split because of their normals
  return {std::llround(p.x() / kGrid_m), std::llround(p.y() / kGrid_m),
          std::llround(p.z() / kGrid_m)};
}

}  // namespace

std::vector<MeshEdge> MeshEdges(const TriangleMesh& mesh) {
  const std::vector<Eigen::Vector3d> normals = FaceNormals(mesh);
  std::map<std::pair<PlaceKey, PlaceKey>, MeshEdge> edges;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (normals[t].isZero(0)) continue;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = mesh.vertices[mesh.triangles[t][k]];
      const Eigen::Vector3d& b = mesh.vertices[mesh.triangles[t][(k + 1) % 3]];
      const PlaceKey key_a = KeyOf(a), key_b = KeyOf(b);
      const auto [it, is_new] = edges.try_emplace(std::minmax(key_a, key_b));
      if (is_new) {
        it->second = {a, b, normals[t], -normals[t]};
      } else {
        it->second.normal_2 = normals[t];
      }
    }
  }
  std::vector<MeshEdge> list;
  list.reserve(edges.size());
  for (const auto& [key, edge] : edges) list.push_back(edge);
  return list;
}

}  // namespace pickbed::scenes
