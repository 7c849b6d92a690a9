#include "grasp/plan/lift_aside.h"

#include <gtest/gtest.h>

#include "grasp/execute/execute.h"
#include "grasp/grippers/suction_cup.h"
#include "tests/grasp/plan/plan_fixture.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(LiftAside, PointsAwayFromTheCover) {
  const Vector2d shift_m = AwayFrom({0.1, 0.02}, {0.06, -0.01}, 0.03);
  EXPECT_TRUE(shift_m.isApprox(Vector2d(-0.024, -0.018), 1e-9)) << shift_m.transpose();
}

TEST(LiftAside, CoverOverTheCenterGivesNoDirection) {
  EXPECT_TRUE(AwayFrom({0.06, -0.012}, {0.06, -0.01}, 0.03).isZero());
}

// The shift of one point and a hand of one box in a bin of 0.4 x 0.3 m.
class ShiftInBinTest : public testing::Test {
 protected:
  Vector2d Shift(const Vector2d& wanted_m) const {
    return ShiftInBin(wanted_m, bin_, Eigen::Matrix3Xd(point_B_), std::vector{hand_}, X_BG_);
  }

  Bin bin_{.inner_size_m = {0.4, 0.3, 0.15}};
  Vector3d point_B_{0, 0, 0.02};
  AxisAlignedBox hand_{{0, 0, 0}, {0.01, 0.02, 0.05}};
  Pose X_BG_ = Pose::Identity();
};

TEST_F(ShiftInBinTest, DoesNotChangeFarFromTheWalls) {
  EXPECT_EQ(Shift({0.03, -0.02}), Vector2d(0.03, -0.02));
}

TEST_F(ShiftInBinTest, EndsOneCentimetreBeforeTheWallOfEitherSide) {
  for (const double side : {-1.0, 1.0}) {
    point_B_.x() = side * 0.175;
    EXPECT_NEAR(Shift({side * 0.03, 0.02}).x(), side * 0.015, 1e-12);
    EXPECT_EQ(Shift({side * 0.03, 0.02}).y(), 0.02);
    EXPECT_EQ(Shift({-side * 0.03, 0}).x(), -side * 0.03) << "away from the wall";
    point_B_.x() = side * 0.195;
    EXPECT_EQ(Shift({side * 0.03, 0}).x(), 0) << "closer than 1 cm: it is not pushed back";
  }
}

TEST_F(ShiftInBinTest, KeepsTheHandOffTheWallsUnlessItIsAboveTheRim) {
  X_BG_ = Translation({0, -0.11, 0.1});
  EXPECT_NEAR(Shift({0, -0.03}).y(), -0.01, 1e-12);
  X_BG_ = Translation({0, -0.11, 0.21});
  EXPECT_EQ(Shift({0, -0.03}).y(), -0.03);
}

TEST_F(ShiftInBinTest, PartsOfTheTargetAboveTheRimAndTablesHaveNoWall) {
  point_B_ = {0.195, 0, 0.16};
  EXPECT_EQ(Shift({0.03, 0}).x(), 0.03);
  bin_.inner_size_m.z() = 0;
  point_B_.z() = -0.01;
  EXPECT_EQ(Shift({0.03, 0}).x(), 0.03);
}

class LiftAsidePlan : public PlanFixture {};

TEST_F(LiftAsidePlan, OnlyACoveredTargetIsPulledAside) {
  AddPose({0, 0, 0.025});
  AddPose({0.04, 0, 0.076});  // over 1 cm of the first one
  const PlanResult plan = Run({.max_grasps = 1000});
  const double length_m = PlanOptions().lift_aside_diameters * objects_[0]->diameter_m;
  int covered = 0, free = 0;
  for (const Grasp& grasp : plan.grasps) {
    if (grasp.hypothesis == 0) {
      ++covered;
      EXPECT_LT(grasp.lift_aside_m.x(), -0.99 * length_m) << "away from the upper cube";
      EXPECT_NEAR(grasp.lift_aside_m.norm(), length_m, 1e-9);
    } else {
      ++free;
      EXPECT_TRUE(grasp.lift_aside_m.isZero());
    }
  }
  EXPECT_GT(covered, 0);
  EXPECT_GT(free, 0);
  int straight = 0;
  for (const Grasp& grasp : Run({.max_grasps = 1000, .lift_aside_diameters = 0}).grasps) {
    straight += grasp.hypothesis == 0;
    EXPECT_TRUE(grasp.lift_aside_m.isZero());
  }
  EXPECT_EQ(straight, covered);
}

// A pull aside bends the lip of a cup.
TEST_F(LiftAsidePlan, CupsLiftStraightUp) {
  SuctionCup cup;
  cup.name = "cup";
  cup.cup.radius_m = cup.cup.stem_radius_m = 0.005;
  cup.cup.vacuum_n = 5;
  cup.cup.moment_limit_nm = 0.02;
  selected_gripper_ = &cup;
  GraspCandidate candidate;
  candidate.X_OG = MakePose(Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), {-0.01, 0, 0.025});
  candidate.quality = 1;
  candidates_ = {{candidate}};
  AddPose({0, 0, 0.025});
  AddPose({0.04, 0, 0.076});
  bool on_the_covered = false;
  for (const Grasp& grasp : Run().grasps) {
    on_the_covered |= grasp.hypothesis == 0;
    EXPECT_TRUE(grasp.lift_aside_m.isZero());
  }
  EXPECT_TRUE(on_the_covered);
}

// The end of a beam is under a slab of 20 kg that two posts support. Straight up, the beam turns
// and slips in the hand until its end is free.
TEST(LiftAside, KeepsABeamInPlaceWhoseEndIsUnderASlab) {
  const double gap_m = 0.0006;
  const ObjectSet objects{BoxObject({0.04, 0.12, 0.04}, 0.2, 0.5),
                          BoxObject({0.04, 0.03, 0.04}, 0.2, 0.5),
                          BoxObject({0.10, 0.16, 0.02}, 20, 0.5)};
  Scene scene;
  const auto add = [&](int object, const Vector3d& p_WO) {
    const InstanceId id(10 + static_cast<int>(scene.objects.size()));
    scene.objects.push_back({id, ObjectId(object), Translation(p_WO)});
  };
  add(0, {0, 0, 0.02 + gap_m});
  add(1, {0, 0.09, 0.02 + gap_m});
  add(1, {0, 0.19, 0.02 + gap_m});
  add(2, {0, 0.135, 0.05 + 2 * gap_m});  // over the last 5 mm of the beam
  const ParallelJaw jaw = SmallJaw();
  Grasp grasp;
  grasp.X_WG = FromAbove({0, -0.01, 0.012});
  grasp.width_m = 0.04;
  ExecuteOptions options;
  options.carry = false;
  const auto run = [&] {
    return ExecuteGrasp(scene, objects, grasp, jaw, InstanceId{10}, options).outcome;
  };
  const GraspOutcome straight = run();
  grasp.lift_aside_m = {0, -PlanOptions().lift_aside_diameters * objects[0]->diameter_m};
  const GraspOutcome aside = run();
  EXPECT_GT(straight.slip_m, 0.002);
  EXPECT_TRUE(aside.success);
  EXPECT_LT(aside.in_hand_rotation_error_rad, 0.5 * straight.in_hand_rotation_error_rad);
  EXPECT_LT(aside.slip_m, 0.5 * straight.slip_m);
}

// A neighbor 2.2 cm beside the beam is too far from the grasp to move, but on the way aside.
TEST(LiftAside, PushesANeighborThatIsOnlyOnTheWayAside) {
  const double gap_m = 0.0006, start_m = -0.097;
  const ObjectSet objects{BoxObject({0.04, 0.12, 0.04}, 0.2, 0.5),
                          BoxObject({0.04, 0.03, 0.04}, 0.05, 0.5)};
  Scene scene;
  scene.objects.push_back({InstanceId{10}, ObjectId{0}, Translation({0, 0, 0.02 + gap_m})});
  scene.objects.push_back({InstanceId{11}, ObjectId{1}, Translation({0, start_m, 0.02 + gap_m})});
  const ParallelJaw jaw = SmallJaw();
  Grasp grasp;
  grasp.X_WG = FromAbove({0, 0, 0.012});
  grasp.width_m = 0.04;
  ExecuteOptions options;
  options.carry = false;
  const auto neighbor_y_m = [&] {
    const Scene after = ExecuteGrasp(scene, objects, grasp, jaw, InstanceId{10}, options).after;
    for (const PosedObject& posed : after.objects) {
      if (posed.instance == InstanceId{11}) return posed.X_WO.translation().y();
    }
    return 0.0;
  };
  EXPECT_EQ(neighbor_y_m(), start_m);
  grasp.lift_aside_m = {0, -0.06};
  EXPECT_LT(neighbor_y_m(), start_m - 0.004);
}

}  // namespace
}  // namespace pickbed::tests
