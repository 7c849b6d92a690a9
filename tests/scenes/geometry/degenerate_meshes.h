#pragma once

// Meshes that break the usual assumptions about geometry, for the tests of all functions of meshes.

#include <limits>
#include <string>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {

// A mesh and what holds for it.
struct DegenerateMesh {
  std::string name;
  TriangleMesh mesh;
  bool has_area = false;
  bool has_volume = false;
};

inline TriangleMesh MeshOf(std::vector<Eigen::Vector3d> vertices,
                           std::vector<Eigen::Vector3i> triangles) {
  TriangleMesh mesh;
  mesh.vertices = std::move(vertices);
  mesh.triangles = std::move(triangles);
  return mesh;
}

// A box in which no triangle shares its vertices.
inline TriangleMesh UnsharedBox() {
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3}, {0, 0, 0});
  TriangleMesh mesh;
  for (const Eigen::Vector3i& t : box.triangles) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const int corner : {t.x(), t.y(), t.z()}) mesh.vertices.push_back(box.vertices[corner]);
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

// A box with faces along an edge, faces of one vertex and a vertex that no face uses.
inline TriangleMesh BoxWithEmptyFaces() {
  TriangleMesh mesh = BoxShape({0.1, 0.2, 0.3}, {0, 0, 0});
  const Eigen::Vector3i t = mesh.triangles.front();
  mesh.vertices.push_back(0.5 * (mesh.vertices[t.x()] + mesh.vertices[t.y()]));
  const int center = static_cast<int>(mesh.vertices.size()) - 1;
  mesh.triangles.emplace_back(t.x(), center, t.y());
  mesh.triangles.emplace_back(t.x(), t.x(), t.x());
  mesh.triangles.emplace_back(t.x(), t.x(), t.y());
  mesh.vertices.emplace_back(0.01, 0.01, 0.01);
  return mesh;
}

inline std::vector<DegenerateMesh> DegenerateMeshes() {
  const Eigen::Vector3d a(0, 0, 0), b(0.1, 0, 0), c(0, 0.1, 0),
      line_1(1.0 / 64, 1.0 / 32, 3.0 / 64);
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3}, {0, 0, 0});
  return {
      {"empty", {}},
      {"no faces", MeshOf({a, b, c}, {})},
      {"one point", MeshOf({a}, {{0, 0, 0}})},
      {"three vertices at one place", MeshOf({b, b, b}, {{0, 1, 2}})},
      {"a line", MeshOf({a, line_1, 2 * line_1, 3 * line_1}, {{0, 1, 2}, {1, 2, 3}, {2, 1, 0}})},
      {"one triangle", MeshOf({a, b, c}, {{0, 1, 2}}), true},
      {"a plate without thickness", MeshOf({a, b, c}, {{0, 1, 2}, {0, 2, 1}}), true},
      {"a face twice", MeshOf({a, b, c}, {{0, 1, 2}, {0, 1, 2}}), true},
      {"a sliver", MeshOf({a, b, {0.05, 1e-9, 0}}, {{0, 1, 2}}), true},
      {"vertices that are not shared", UnsharedBox(), true, true},
      {"faces without area", BoxWithEmptyFaces(), true, true},
      {"a far box", BoxShape({0.1, 0.2, 0.3}, {1e4, -1e4, 1e4}), true, true},
      {"a tiny box", BoxShape({1e-6, 2e-6, 3e-6}, {0, 0, 0}), true, true},
      {"a huge box", BoxShape({1e5, 2e5, 3e5}, {0, 0, 0}), true, true},
  };
}

}  // namespace pickbed::tests
