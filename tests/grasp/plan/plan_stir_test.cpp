#include "grasp/plan/plan_stir.h"

#include <gtest/gtest.h>

#include "grasp/plan/clearance.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kHeight_m = 0.06;

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

  StirPath Path(int number) const { return PlanStir(bin_, cloud_W_, gripper_, number); }

  Bin bin_;
  ParallelJaw gripper_ = SmallJaw();
  std::vector<Vector3d> cloud_W_;
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

}  // namespace
}  // namespace pickbed::tests
