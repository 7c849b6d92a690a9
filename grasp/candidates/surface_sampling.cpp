#include "grasp/candidates/surface_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

// Index of the position of each vertex. Texture seams have several vertices at one position.
std::vector<int> Places(const TriangleMesh& mesh) {
  std::map<std::array<double, 3>, int> known;
  std::vector<int> places;
  for (const Vector3d& p : mesh.vertices) {
    const int next = static_cast<int>(known.size());
    places.push_back(known.try_emplace({p.x(), p.y(), p.z()}, next).first->second);
  }
  return places;
}

struct Edge {
  int from = 0, to = 0;             // vertex indices
  std::vector<Vector3d> normals_O;  // one per adjacent face
};

// True if two faces meet at less than `turn_rad`. Faces without area are not counted.
bool IsFlat(const Edge& edge, double turn_rad) {
  return edge.normals_O.size() == 2 &&
         edge.normals_O[0].dot(edge.normals_O[1]) >= std::cos(turn_rad);
}

std::vector<Edge> EdgesOf(const TriangleMesh& mesh) {
  const std::vector<int> places = Places(mesh);
  std::map<std::pair<int, int>, Edge> edges;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3d normal = (b - a).cross(c - a);
    if (!(normal.norm() > 0)) continue;
    for (int i = 0; i < 3; ++i) {
      const int from = t[i], to = t[(i + 1) % 3];
      Edge& edge = edges[std::minmax(places[from], places[to])];
      edge.from = from;
      edge.to = to;
      edge.normals_O.push_back(normal.normalized());
    }
  }
  std::vector<Edge> list;
  for (auto& [key, edge] : edges) list.push_back(std::move(edge));
  return list;
}

}  // namespace

Eigen::Matrix3Xd SharpEdgePoints(const TriangleMesh& mesh, double spacing_m, double turn_rad) {
  // Edges of rims are far shorter than the spacing. So one point is kept per cell of half the
  // spacing.
  const double cell_m = 0.5 * spacing_m;
  std::set<std::array<int64_t, 3>> taken;
  std::vector<Vector3d> points;
  const auto add = [&](const Vector3d& p) {
    const auto cell = [&](double value) { return std::llround(value / cell_m); };
    if (taken.insert({cell(p.x()), cell(p.y()), cell(p.z())}).second) points.push_back(p);
  };
  for (const Edge& edge : EdgesOf(mesh)) {
    if (IsFlat(edge, turn_rad)) continue;
    const Vector3d &a = mesh.vertices[edge.from], &b = mesh.vertices[edge.to];
    const int steps = std::max(1, static_cast<int>(std::ceil((b - a).norm() / cell_m)));
    for (int i = 0; i <= steps; ++i) add(a + (b - a) * i / steps);
  }
  Eigen::Matrix3Xd columns(3, points.size());
  for (size_t i = 0; i < points.size(); ++i) columns.col(i) = points[i];
  return columns;
}

}  // namespace pickbed::grasp
