#pragma once

// Meshes and cameras for tests of the renderer.

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "scenes/camera/camera.h"
#include "scenes/geometry/triangle_mesh.h"
#include "sim/render/renderer.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// No levels of detail: the original meshes are drawn.
inline constexpr DetailOptions kOriginal{0, 0};

// Returns a closed sphere about the origin: an icosahedron divided `levels` times.
inline TriangleMesh SphereMesh(double radius_m, int levels) {
  const double t = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> midpoints;
    const auto midpoint = [&](int a, int b) {
      const auto [it, added] =
          midpoints.try_emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
      if (added) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return it->second;
    };
    for (auto& v : mesh.vertices) v.normalize();
    std::vector<Eigen::Vector3i> finer;
    for (const Eigen::Vector3i& f : mesh.triangles) {
      const int a = midpoint(f[0], f[1]), b = midpoint(f[1], f[2]), c = midpoint(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  for (auto& v : mesh.vertices) v = radius_m * v.normalized();
  return mesh;
}

// Returns a closed box about the origin.
inline TriangleMesh BoxMesh(const Eigen::Vector3d& size_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(
        0.5 * size_m.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// Returns an open rectangle in the plane z = 0 with corners (x0, y0) and (x1, y1). It faces -z, so
// a camera at the origin of its frame sees it upright. uv (0, 0) is at (x0, y0).
inline TriangleMesh RectangleMesh(double x0, double y0, double x1, double y1) {
  TriangleMesh mesh;
  mesh.vertices = {{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return mesh;
}

inline Camera TestCamera(int width, int height, double focal_px) {
  Camera camera;
  camera.intrinsics = {width, height, focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1)};
  return camera;
}

}  // namespace pickbed::tests
