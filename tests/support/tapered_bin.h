#pragma once

// Meshes of bins that are no boxes.

#include <vector>

#include "scenes/geometry/triangle_mesh.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

struct RectangleAt {
  double length, width, z;  // m
};

// Returns the bands between consecutive rectangles about the z axis. Faces point outwards if the
// rectangles go up the outside of a wall and then down its inside.
inline TriangleMesh BandsBetween(const std::vector<RectangleAt>& rings, bool closed) {
  TriangleMesh mesh;
  for (const RectangleAt& r : rings) {
    const double x = 0.5 * r.length, y = 0.5 * r.width;
    for (const auto& [sx, sy] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      mesh.vertices.emplace_back(sx * x, sy * y, r.z);
    }
  }
  const int count = static_cast<int>(rings.size());
  for (int ring = 0; ring < (closed ? count : count - 1); ++ring) {
    const int from = 4 * ring, to = 4 * ((ring + 1) % count);
    for (int i = 0; i < 4; ++i) {
      const int j = (i + 1) % 4;
      mesh.triangles.emplace_back(from + i, from + j, to + j);
      mesh.triangles.emplace_back(from + i, to + j, to + i);
    }
  }
  return mesh;
}

// Returns a bin with sloped walls: inside 0.3 x 0.2 m at the floor, 0.4 x 0.28 m at the rim, 0.12 m
// high, 4 mm thick.
inline TriangleMesh TaperedBin() {
  TriangleMesh mesh = BandsBetween(
      {{0.308, 0.208, -0.004}, {0.408, 0.288, 0.12}, {0.4, 0.28, 0.12}, {0.3, 0.2, 0}}, false);
  mesh.triangles.insert(mesh.triangles.end(), {{0, 2, 1}, {0, 3, 2}, {12, 13, 14}, {12, 14, 15}});
  return mesh;
}

inline TriangleMesh WallsWithoutFloor() {
  return BandsBetween({{0.41, 0.31, 0}, {0.41, 0.31, 0.15}, {0.4, 0.3, 0.15}, {0.4, 0.3, 0}}, true);
}

}  // namespace pickbed::tests
