#include "grasp/plan/stacking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Points of a horizontal square plate with its lower corner at (x, y, z), spaced by 2.5 mm.
Eigen::Matrix3Xd Plate(double x_m, double y_m, double z_m, int side = 40) {
  Eigen::Matrix3Xd points(3, side * side);
  for (int i = 0; i < points.cols(); ++i) {
    points.col(i) = Eigen::Vector3d(x_m + 0.0025 * (i % side), y_m + 0.0025 * (i / side), z_m);
  }
  return points;
}

TEST(InstancesAbove, PlateOnTwoPlatesIsAboveBoth) {
  const std::vector<Eigen::Matrix3Xd> plates{Plate(0, 0, 0), Plate(0.05, 0, 0.01),
                                             Plate(0.11, 0, 0)};
  const auto above = InstancesAbove(plates, 0.005);
  EXPECT_THAT(above[0], ElementsAre(1));
  EXPECT_THAT(above[1], IsEmpty());
  EXPECT_THAT(above[2], ElementsAre(1));
}

TEST(InstancesAbove, HigherInstanceBesideIsNotAbove) {
  const std::vector<Eigen::Matrix3Xd> plates{Plate(0, 0, 0), Plate(0.12, 0, 0.05)};
  EXPECT_THAT(InstancesAbove(plates, 0.005), ElementsAre(IsEmpty(), IsEmpty()));
}

TEST(InstancesAbove, CrossedInstancesAreDecidedByTheLargerPart) {
  // The second plate is tilted about y: a fifth of it is below the first one.
  Eigen::Matrix3Xd tilted = Plate(0, 0, 0);
  tilted.row(2) = 0.2 * (tilted.row(0).array() - 0.02);
  const std::vector<Eigen::Matrix3Xd> plates{Plate(0, 0, 0), tilted};
  EXPECT_THAT(InstancesAbove(plates, 0.005), ElementsAre(ElementsAre(1), IsEmpty()));
}

TEST(InstancesAbove, NothingIsAboveWithoutPoses) {
  EXPECT_THAT(InstancesAbove({}, 0.005), IsEmpty());
  EXPECT_THAT(InstancesAbove(std::vector<Eigen::Matrix3Xd>{Eigen::Matrix3Xd(3, 0)}, 0.005),
              ElementsAre(IsEmpty()));
}

}  // namespace
}  // namespace pickbed::tests
