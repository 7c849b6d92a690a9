// Convex hulls and pieces of degenerate points and meshes.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes/base/error.h"
#include "sim/convex/convex_cuts.h"
#include "sim/convex/convex_hull.h"
#include "sim/convex/convex_pieces.h"
#include "tests/scenes/geometry/degenerate_meshes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

struct PointsCase {
  const char* name;
  std::vector<Vector3d> points;
  bool has_volume = false;
};

TEST(DegenerateConvexHull, IsEmptyWithoutAVolume) {
  const Vector3d a(0, 0, 0), b(0.1, 0, 0), c(0, 0.1, 0), d(0, 0, 0.1);
  const PointsCase cases[] = {{"none", {}},
                              {"one point", {a}},
                              {"one point often", std::vector<Vector3d>(50, b)},
                              {"two points", {a, b}},
                              {"a line", {a, b, 2 * b, 3 * b, 4 * b}},
                              {"three points", {a, b, c}},
                              {"a plane", {a, b, c, b + c, 0.5 * (b + c)}},
                              {"a tetrahedron", {a, b, c, d}, true},
                              {"its corners twice", {a, b, c, d, a, b, c, d}, true},
                              {"with points on its faces", {a, b, c, d, 0.5 * b, 0.3 * c}, true}};
  for (const PointsCase& test : cases) {
    const ConvexHull hull = MakeConvexHull(test.points);
    EXPECT_EQ(hull.vertices.size() >= 4, test.has_volume) << test.name;
    EXPECT_EQ(hull.Volume() > 0, test.has_volume) << test.name;
    for (const Vector3d& n : hull.normals) EXPECT_NEAR(n.norm(), 1, 1e-9) << test.name;
  }
}

TEST(DegenerateConvexPieces, MeshesWithoutVolumeAreRefused) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    try {
      const std::vector<ConvexPiece> pieces = DecomposeConvex(test.mesh);
      EXPECT_TRUE(test.has_volume || pieces.empty()) << test.name;
      EXPECT_TRUE(!test.has_volume || !pieces.empty()) << test.name;
      for (const ConvexPiece& piece : pieces) {
        for (const Vector3d& v : piece.vertices_O) EXPECT_TRUE(v.allFinite()) << test.name;
      }
    } catch (const InputError&) {
      EXPECT_FALSE(test.has_volume) << test.name;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
