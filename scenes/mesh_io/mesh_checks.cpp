#include "scenes/mesh_io/mesh_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/geometry/mass_properties.h"

namespace pickbed::scenes {
namespace {

// Returns, for each vertex, the index of the first vertex at the same place.
std::vector<int> WeldByPosition(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<int> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const Eigen::Vector3d& p = vertices[a];
    const Eigen::Vector3d& q = vertices[b];
    return std::tie(p.x(), p.y(), p.z(), a) < std::tie(q.x(), q.y(), q.z(), b);
  });
  std::vector<int> welded(vertices.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    welded[order[i]] = same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

void CountEdges(const TriangleMesh& mesh, MeshReport& report) {
  const std::vector<int> welded = WeldByPosition(mesh.vertices);
  // For each side of each face: low end, high end, whether it runs from low to high.
  std::vector<std::tuple<int, int, bool>> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = welded[t[k]];
      const int b = welded[t[(k + 1) % 3]];
      if (a != b) sides.emplace_back(std::min(a, b), std::max(a, b), a < b);
    }
  }
  std::sort(sides.begin(), sides.end());
  for (size_t begin = 0; begin < sides.size();) {
    const auto [low, high, unused] = sides[begin];
    size_t end = begin;
    int forward = 0;
    for (; end < sides.size() && std::get<0>(sides[end]) == low && std::get<1>(sides[end]) == high;
         ++end) {
      forward += std::get<2>(sides[end]);
    }
    const int faces = static_cast<int>(end - begin);
    report.open_edges += faces % 2;
    report.flipped_edges += faces == 2 && forward != 1;
    begin = end;
  }
}

double SignedVolume(const TriangleMesh& mesh) {
  const Eigen::Vector3d center = MeshBounds(mesh).center();
  double six_volumes = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]] - center;
    const Eigen::Vector3d b = mesh.vertices[t[1]] - center;
    const Eigen::Vector3d c = mesh.vertices[t[2]] - center;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

}  // namespace

MeshReport InspectMesh(const TriangleMesh& mesh) {
  MeshReport report;
  report.triangles = static_cast<int>(mesh.triangles.size());
  report.finite = std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                              [](const Eigen::Vector3d& v) { return v.allFinite(); });
  if (!report.finite) return report;  // NaN has no order and no volume
  CountEdges(mesh, report);
  report.volume_m3 = SignedVolume(mesh);
  return report;
}

void RequireUsableMesh(const TriangleMesh& mesh, const std::string& source) {
  CheckInput(!mesh.triangles.empty(),
             "mesh '" + source + "' has no faces; export it as triangles, not as points or lines");
  const bool finite = std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                                  [](const Eigen::Vector3d& v) { return v.allFinite(); });
  CheckInput(finite, "mesh '" + source +
                         "' has vertices that are not numbers (NaN or infinite); export it again");
  const double scale_m3 = std::pow(MeshBounds(mesh).size().norm(), 3);
  CheckInput(std::abs(SignedVolume(mesh)) > kFlatVolumeRatio * scale_m3,
             "mesh '" + source +
                 "' encloses no volume: it is flat or its faces have random orientations; give it "
                 "a thickness and orient all faces outwards");
}

TriangleMesh TurnedOutwards(TriangleMesh mesh) {
  if (SignedVolume(mesh) >= 0) return mesh;
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  if (mesh.normals.empty()) return mesh;
  const std::vector<Eigen::Vector3d> faces = FaceNormals(mesh);
  double agreement = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    for (const int corner : mesh.triangles[i]) agreement += faces[i].dot(mesh.normals[corner]);
  }
  if (agreement < 0) {
    for (Eigen::Vector3d& n : mesh.normals) n = -n;
  }
  return mesh;
}

TriangleMesh WithAgreeingFaces(TriangleMesh mesh) {
  const std::vector<int> welded = WeldByPosition(mesh.vertices);
  struct Side {
    int face;
    bool is_forward;  // from the lower to the higher vertex
  };
  std::map<std::pair<int, int>, std::vector<Side>> sides;
  const int count = static_cast<int>(mesh.triangles.size());
  for (int face = 0; face < count; ++face) {
    for (int k = 0; k < 3; ++k) {
      const int a = welded[mesh.triangles[face][k]], b = welded[mesh.triangles[face][(k + 1) % 3]];
      if (a != b) sides[std::minmax(a, b)].push_back({face, a < b});
    }
  }
  struct Neighbor {
    int face;
    bool agrees;
  };
  std::vector<std::vector<Neighbor>> neighbors(count);
  for (const auto& [edge, of_edge] : sides) {
    if (of_edge.size() != 2) continue;  // an open edge, or a joint of several surfaces
    const bool agrees = of_edge[0].is_forward != of_edge[1].is_forward;
    neighbors[of_edge[0].face].push_back({of_edge[1].face, agrees});
    neighbors[of_edge[1].face].push_back({of_edge[0].face, agrees});
  }
  std::vector<int> turned(count, -1);  // against the first face of the group; -1 = not reached
  bool is_changed = false;
  for (int seed = 0; seed < count; ++seed) {
    if (turned[seed] >= 0) continue;
    std::vector<int> group{seed};
    turned[seed] = 0;
    std::array<double, 2> area{};
    for (size_t i = 0; i < group.size(); ++i) {
      const Eigen::Vector3i& t = mesh.triangles[group[i]];
      const std::vector<Eigen::Vector3d>& v = mesh.vertices;
      area[turned[group[i]]] += (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm();
      for (const Neighbor& neighbor : neighbors[group[i]]) {
        if (turned[neighbor.face] >= 0) continue;
        turned[neighbor.face] = turned[group[i]] ^ (neighbor.agrees ? 0 : 1);
        group.push_back(neighbor.face);
      }
    }
    const int wrong = area[0] >= area[1] ? 1 : 0;
    for (const int face : group) {
      if (turned[face] != wrong) continue;
      std::swap(mesh.triangles[face][1], mesh.triangles[face][2]);
      is_changed = true;
    }
  }
  if (is_changed) mesh.normals.clear();
  return mesh;
}

TriangleMesh WithoutRepeatedFaces(TriangleMesh mesh) {
  using Place = std::array<double, 3>;
  std::set<std::array<Place, 3>> seen;
  const auto is_repeated = [&](const Eigen::Vector3i& triangle) {
    std::array<Place, 3> face;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = mesh.vertices[triangle[k]];
      face[k] = {p.x(), p.y(), p.z()};
    }
    // Starting at the smallest corner makes faces comparable and keeps their winding.
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return !seen.insert(face).second;
  };
  auto& triangles = mesh.triangles;
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(), is_repeated), triangles.end());
  return mesh;
}

}  // namespace pickbed::scenes
