#include "grasp/plan/plan_stir.h"

#include <gtest/gtest.h>

#include "grasp/plan/clearance.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kHeight_m = 0.06;

ParallelJaw LongJaw() {
  ParallelJaw jaw = SmallJaw();
  jaw.hand.finger_size_m.z() = 0.2;
  return jaw;
}

class PlanStirTest : public testing::Test {
 protected:
  // Adds the points of a block of 40 x 40 mm on the floor.
  void AddBlock(double x_m, double y_m, double height_m = kHeight_m) {
    for (int i = 0; i <= 20; ++i) {
      for (int k = 0; k <= 20; ++k) {
        cloud_W_.emplace_back(x_m + 0.002 * (i - 10), y_m + 0.002 * (k - 10), height_m);
      }
    }
  }

  // Adds the floor and the inner side of one wall.
  void AddBin() {
    for (double x_m = -0.2; x_m <= 0.2; x_m += 0.004) {
      for (double y_m = -0.15; y_m <= 0.15; y_m += 0.004) cloud_W_.emplace_back(x_m, y_m, 0.001);
      for (double z_m = 0; z_m <= 0.15; z_m += 0.004) cloud_W_.emplace_back(x_m, 0.149, z_m);
    }
  }

  StirPath Path(int number) const { return PlanStir(bin_, cloud_W_, gripper_, number, sweeps_); }
  // With fingers that are longer than the bin is deep, so that the palm stays above the walls.
  StirPath Drag(int number) const { return PlanStir(bin_, cloud_W_, LongJaw(), number); }

  Bin bin_;
  ParallelJaw gripper_ = SmallJaw();
  std::vector<Vector3d> cloud_W_;
  const PlanStirOptions sweeps_{.drag_share = 0};
};

// Paths alternate; each stays off the walls and the floor, and meets the only instance.
TEST_F(PlanStirTest, PathsStayInTheBinAndMeetTheInstance) {
  AddBin();
  AddBlock(0, 0);
  for (int number = 0; number < 8; ++number) {
    const StirPath path = Path(number);
    const Vector3d from = path.X_WG_from.translation(), to = path.X_WG_to.translation();
    EXPECT_LT((from + to).head<2>().norm(), 1e-9) << "the instance is in the center";
    EXPECT_GT((to - from).norm(), 0.1) << number;
    EXPECT_NEAR(from.z(), kHeight_m - PlanStirOptions().depth_m, 1e-9);
    EXPECT_GE(from.z() + path.rise_m, bin_.inner_size_m.z()) << "descends from above the rim";
    for (const Pose& X_WG : {path.X_WG_from, path.X_WG_to}) {
      EXPECT_FALSE(FindBinContact(gripper_.Boxes(0), X_WG, BinBoxes(bin_), 0.004)) << number;
    }
    EXPECT_FALSE(Path(number + 1).X_WG_to.isApprox(path.X_WG_to)) << number;
  }
}

// The path along the bin follows the points to the wall.
TEST_F(PlanStirTest, PathGoesWhereMostPointsAre) {
  for (const double x_m : {-0.1, 0.0, 0.1}) AddBlock(x_m, 0.11);
  AddBlock(0.05, -0.05);
  const StirPath path = Path(0);
  EXPECT_GT(path.X_WG_from.translation().y(), 0.05);
  EXPECT_EQ(path.X_WG_from.translation().y(), path.X_WG_to.translation().y());
  EXPECT_LT(path.X_WG_from.translation().x(), path.X_WG_to.translation().x());
}

TEST_F(PlanStirTest, SingleHighInstanceDoesNotRaiseThePath) {
  for (const double x_m : {-0.1, 0.0, 0.1}) {
    for (const double y_m : {-0.05, 0.05}) AddBlock(x_m, y_m);
  }
  const double without_m = Path(0).X_WG_from.translation().z();
  AddBlock(0.17, 0.1, 0.17);
  EXPECT_EQ(Path(0).X_WG_from.translation().z(), without_m);
  EXPECT_GT(without_m + Path(0).rise_m, 0.17) << "but the hand passes above it";
}

TEST_F(PlanStirTest, EmptyCloudGivesAPathAboveTheFloor) {
  EXPECT_EQ(Path(0).X_WG_from.translation().z(), PlanStirOptions().floor_m);
}

// The tips press on the top of the instance, as near to the wall as they can, and move away from
// it.
TEST_F(PlanStirTest, LastInstanceAtAWallIsDraggedAwayFromIt) {
  AddBin();
  AddBlock(0.175, 0.02);
  const StirPath path = Drag(0);
  const Vector3d from = path.X_WG_from.translation(), to = path.X_WG_to.translation();
  EXPECT_NEAR(from.z(), kHeight_m - PlanStirOptions().press_m, 1e-9);
  EXPECT_NEAR(from.x(), 0.175, 0.02);
  EXPECT_NEAR(from.y(), 0.02, 0.021);
  EXPECT_NEAR(to.x() - from.x(), -PlanStirOptions().drag_m, 1e-9);
  EXPECT_EQ(to.y(), from.y());
  EXPECT_EQ(to.z(), from.z());
  EXPECT_GE(from.z() + path.rise_m, bin_.inner_size_m.z());
  EXPECT_FALSE(FindBinContact(LongJaw().Boxes(0), path.X_WG_from, BinBoxes(bin_), 0.002));
}

// The palm of a hand with short fingers meets the walls. It would press on the inner side of an
// instance at a wall.
TEST_F(PlanStirTest, HandWithShortFingersDoesNotDrag) {
  for (const double x_m : {0.1, 0.13, 0.175}) {
    cloud_W_.clear();
    AddBlock(x_m, 0.02);
    EXPECT_TRUE(PlanStir(bin_, cloud_W_, gripper_, 0).X_WG_from.isApprox(Path(0).X_WG_from)) << x_m;
  }
}

TEST_F(PlanStirTest, LastInstanceInACornerIsDraggedAwayFromBothWalls) {
  AddBlock(-0.17, 0.12);
  const Vector3d way = Drag(0).X_WG_to.translation() - Drag(0).X_WG_from.translation();
  EXPECT_GT(way.x(), 0.05);
  EXPECT_NEAR(way.y(), -way.x(), 1e-9);
}

TEST_F(PlanStirTest, NextDragsReachTheOtherInstance) {
  AddBlock(0.17, 0);
  AddBlock(-0.16, 0);
  EXPECT_GT(Drag(0).X_WG_from.translation().x(), 0.1) << "it is nearer to its wall";
  EXPECT_FALSE(Drag(1).X_WG_from.isApprox(Drag(0).X_WG_from));
  int other = 0;
  for (int number = 0; number < 4; ++number) {
    other += Drag(number).X_WG_from.translation().x() < -0.1;
  }
  EXPECT_GT(other, 0);
  EXPECT_LT(other, 4);
}

// Readings at the rim and single ones nearer to a wall are noise.
TEST_F(PlanStirTest, NoiseIsNotDragged) {
  AddBlock(0.1, 0);
  const StirPath without = Drag(0);
  for (double y_m = -0.1; y_m <= 0.1; y_m += 0.002) {
    for (const double z_m : {0.14, 0.145, 0.15, 0.16}) cloud_W_.emplace_back(-0.18, y_m, z_m);
  }
  cloud_W_.emplace_back(0, 0.12, 0.03);
  EXPECT_TRUE(Drag(0).X_WG_from.isApprox(without.X_WG_from));
  EXPECT_TRUE(Drag(0).X_WG_to.isApprox(without.X_WG_to));
}

// Many instances are swept, because a path through the middle meets them.
TEST_F(PlanStirTest, ManyInstancesAreSwept) {
  for (const double x_m : {-0.15, -0.05, 0.05, 0.15}) {
    for (const double y_m : {-0.1, -0.03, 0.04, 0.11}) AddBlock(x_m, y_m);
  }
  const StirPath path = PlanStir(bin_, cloud_W_, LongJaw(), 0, sweeps_);
  EXPECT_TRUE(Drag(0).X_WG_from.isApprox(path.X_WG_from));
}

}  // namespace
}  // namespace pickbed::tests
