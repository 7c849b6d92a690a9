#include "sim/convex/convex_hull.h"

#include <LinearMath/btConvexHullComputer.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "scenes/base/error.h"

namespace pickbed::sim {
namespace {

// Sums the cross products of a triangle fan. The result is the polygon's normal with twice its area
// as length.
Eigen::Vector3d FanNormal(const std::vector<Eigen::Vector3d>& vertices,
                          const std::vector<int>& loop) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (size_t i = 2; i < loop.size(); ++i) {
    const Eigen::Vector3d& origin = vertices[loop[0]];
    normal += (vertices[loop[i - 1]] - origin).cross(vertices[loop[i]] - origin);
  }
  return normal;
}

}  // namespace

double ConvexHull::Volume() const {
  double six_volumes = 0;
  for (const Eigen::Vector3i& t : triangles) {
    const Eigen::Vector3d& origin = vertices[0];
    six_volumes +=
        (vertices[t[0]] - origin).dot((vertices[t[1]] - origin).cross(vertices[t[2]] - origin));
  }
  return six_volumes / 6;
}

ConvexHull MakeConvexHull(std::span<const Eigen::Vector3d> points) {
  ConvexHull hull;
  if (points.size() < 4) return hull;
  CheckInput(std::all_of(points.begin(), points.end(),
                         [](const Eigen::Vector3d& p) { return p.allFinite(); }),
             "a point of a convex hull is not finite; repair the mesh or the piece");
  // Bullet's hull works on integers, so its topology is consistent. It rounds coordinates to 1e-4
  // of the size; therefore the given coordinates are copied instead.
  btConvexHullComputer computer;
  computer.compute(points[0].data(), sizeof(Eigen::Vector3d), static_cast<int>(points.size()), 0,
                   0);
  if (computer.faces.size() < 4) return hull;
  for (int i = 0; i < computer.vertices.size(); ++i) {
    hull.vertices.push_back(points[computer.original_vertex_index[i]]);
  }
  std::vector<int> face_of_edge(computer.edges.size(), -1);
  const auto index = [&](const btConvexHullComputer::Edge* edge) {
    return static_cast<int>(edge - &computer.edges[0]);
  };
  std::vector<int> loop;
  for (int face = 0; face < computer.faces.size(); ++face) {
    loop.clear();
    const btConvexHullComputer::Edge* const first = &computer.edges[computer.faces[face]];
    const btConvexHullComputer::Edge* edge = first;
    do {
      face_of_edge[index(edge)] = face;
      loop.push_back(edge->getSourceVertex());
      edge = edge->getNextEdgeOfFace();
    } while (edge != first);
    for (size_t i = 2; i < loop.size(); ++i) {
      hull.triangles.emplace_back(loop[0], loop[i - 1], loop[i]);
      hull.triangle_faces.push_back(face);
    }
    hull.normals.push_back(FanNormal(hull.vertices, loop).normalized());
  }
  for (int i = 0; i < computer.edges.size(); ++i) {
    const btConvexHullComputer::Edge& edge = computer.edges[i];
    const int reverse = index(edge.getReverseEdge());
    if (reverse < i) continue;
    hull.edges.push_back(
        {edge.getSourceVertex(), edge.getTargetVertex(), face_of_edge[i], face_of_edge[reverse]});
  }
  return hull;
}

}  // namespace pickbed::sim
