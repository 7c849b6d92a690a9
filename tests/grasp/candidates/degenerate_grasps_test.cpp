// Geometry of grasps on degenerate meshes and sets of wrenches.

#include <gtest/gtest.h>

#include <cmath>

#include "grasp/candidates/surface_sampling.h"
#include "grasp/candidates/wrench_space.h"
#include "tests/scenes/geometry/degenerate_meshes.h"

namespace pickbed::tests {
namespace {

TEST(DegenerateSharpEdges, PointsAreFinite) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    const Bounds bounds = MeshBounds(test.mesh);
    const double spacing_m = std::max(1e-9, 0.05 * bounds.size().norm());
    const Eigen::Matrix3Xd points = SharpEdgePoints(test.mesh, spacing_m);
    EXPECT_TRUE(points.allFinite()) << test.name;
    EXPECT_TRUE(test.has_area || points.cols() == 0) << test.name;
  }
}

// A set of wrenches without a volume resists nothing, and zero load is always balanced by zero.
TEST(DegenerateWrenchSets, ResistNothing) {
  const Wrench x = Wrench::Unit(0), load = Wrench::Unit(3);
  WrenchSet none, one_point, line;
  one_point.regions = {Wrenches(x)};
  Wrenches both(6, 2);
  both << x, -x;
  line.regions = {both};
  for (const WrenchSet& set : {none, one_point, line}) {
    const WrenchDepth depth = DepthOfZero(set);
    EXPECT_TRUE(std::isfinite(depth.lower) && std::isfinite(depth.upper));
    EXPECT_EQ(depth.lower, 0);
    EXPECT_TRUE(Balances(set, Wrench::Zero()));
    EXPECT_FALSE(Balances(set, load));
    EXPECT_TRUE(set.Support(x).allFinite());
  }
}

}  // namespace
}  // namespace pickbed::tests
