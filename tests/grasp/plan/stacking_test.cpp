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

// The instances above each instance.
std::vector<std::vector<int>> InstancesAbove(const std::vector<Eigen::Matrix3Xd>& surfaces_W,
                                             double cell_m) {
  InstanceStack stack(cell_m);
  for (const Eigen::Matrix3Xd& surface_W : surfaces_W) stack.Add(surface_W);
  std::vector<std::vector<int>> above;
  for (size_t i = 0; i < surfaces_W.size(); ++i) above.push_back(stack.Above(static_cast<int>(i)));
  return above;
}

TEST(InstanceStack, PlateOnTwoPlatesIsAboveBoth) {
  const std::vector<Eigen::Matrix3Xd> plates{Plate(0, 0, 0), Plate(0.05, 0, 0.01),
                                             Plate(0.11, 0, 0)};
  const auto above = InstancesAbove(plates, 0.005);
  EXPECT_THAT(above[0], ElementsAre(1));
  EXPECT_THAT(above[1], IsEmpty());
  EXPECT_THAT(above[2], ElementsAre(1));
}

TEST(InstanceStack, HigherInstanceBesideIsNotAbove) {
  const std::vector<Eigen::Matrix3Xd> plates{Plate(0, 0, 0), Plate(0.12, 0, 0.05)};
  EXPECT_THAT(InstancesAbove(plates, 0.005), ElementsAre(IsEmpty(), IsEmpty()));
}

TEST(InstanceStack, CrossedInstancesAreDecidedByTheLargerPart) {
  // The second plate is tilted about y: a fifth of it is below the first one.
  Eigen::Matrix3Xd tilted = Plate(0, 0, 0);
  tilted.row(2) = 0.2 * (tilted.row(0).array() - 0.02);
  const std::vector<Eigen::Matrix3Xd> plates{Plate(0, 0, 0), tilted};
  EXPECT_THAT(InstancesAbove(plates, 0.005), ElementsAre(ElementsAre(1), IsEmpty()));
}

TEST(InstanceStack, CenterOfCoverIsWhereOthersRestOnTheInstance) {
  InstanceStack stack(0.005);
  stack.Add(Plate(0, 0, 0));
  stack.Add(Plate(0.08, 0, 0.01));   // rests on the last 2 cm of the first one
  stack.Add(Plate(-0.05, 0, 0.05));  // 5 cm above it
  const auto center = stack.CenterOfCover(0, {true, true, true});
  ASSERT_TRUE(center.has_value());
  EXPECT_NEAR(center->x(), 0.09, 0.003);
  EXPECT_NEAR(center->y(), 0.05, 0.003);
  EXPECT_FALSE(stack.CenterOfCover(0, {true, false, true}).has_value()) << "it does not count";
  EXPECT_FALSE(stack.CenterOfCover(2, {true, true, true}).has_value()) << "nothing is on it";
}

TEST(InstanceStack, NothingIsAboveWithoutPoses) {
  EXPECT_THAT(InstancesAbove({}, 0.005), IsEmpty());
  EXPECT_THAT(InstancesAbove(std::vector<Eigen::Matrix3Xd>{Eigen::Matrix3Xd(3, 0)}, 0.005),
              ElementsAre(IsEmpty()));
}

}  // namespace
}  // namespace pickbed::tests
