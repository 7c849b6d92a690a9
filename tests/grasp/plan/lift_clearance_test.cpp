#include "grasp/plan/lift_clearance.h"

#include <gtest/gtest.h>

#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

// A cube of 40 mm in the default bin of 40 x 30 x 15 cm.
bool MeetsAt(const Eigen::Vector3d& center_B, double clearance_m = 0, const Bin& bin = {}) {
  return LiftMeetsWall(bin, *BoxObject({0.04, 0.04, 0.04}, 0.1), Translation(center_B),
                       clearance_m);
}

TEST(LiftMeetsWall, ClearanceIsKeptFromEachWall) {
  const Eigen::Vector3d half = 0.5 * Bin().inner_size_m;
  for (const double side : {-1.0, 1.0}) {
    const double x_m = side * (half.x() - 0.02 - 0.003), y_m = side * (half.y() - 0.02 - 0.003);
    for (const Eigen::Vector3d& center : {Eigen::Vector3d(x_m, 0, 0.02), {0, y_m, 0.02}}) {
      EXPECT_FALSE(MeetsAt(center));
      EXPECT_FALSE(MeetsAt(center, 0.002));
      EXPECT_TRUE(MeetsAt(center, 0.004));
    }
  }
}

// An estimate may have an error of some millimeters at an instance that leans on the wall.
TEST(LiftMeetsWall, NegativeClearanceAllowsAnOverlap) {
  const double touching_m = 0.5 * Bin().inner_size_m.x() - 0.02;
  EXPECT_TRUE(MeetsAt({touching_m + 0.001, 0, 0.02}));
  EXPECT_FALSE(MeetsAt({touching_m + 0.001, 0, 0.02}, -0.002));
  EXPECT_TRUE(MeetsAt({touching_m + 0.003, 0, 0.02}, -0.002));
}

TEST(LiftMeetsWall, ObjectAboveTheRimMeetsNothing) {
  const Bin bin;
  const double outside_m = 0.5 * bin.inner_size_m.x();
  EXPECT_TRUE(MeetsAt({outside_m, 0, bin.inner_size_m.z()}));
  EXPECT_FALSE(MeetsAt({outside_m, 0, bin.inner_size_m.z() + 0.021}));
}

TEST(LiftMeetsWall, TableHasNoWalls) {
  Bin table;
  table.inner_size_m.z() = 0;
  EXPECT_FALSE(MeetsAt({5, 0, 0.02}, 0, table));
}

// The wide floor of a bin with a narrow opening has room for a cube that the opening has not.
TEST(LiftMeetsWall, NarrowOpeningStopsAnObjectBelowItsEdge) {
  Bin narrow;
  narrow.inner_size_m.x() = 0.30;  // of the opening; the floor is 40 cm long
  EXPECT_FALSE(MeetsAt({0.12, 0, 0.02}, 0, narrow));
  EXPECT_TRUE(MeetsAt({0.17, 0, 0.02}, 0, narrow));
}

}  // namespace
}  // namespace pickbed::tests
