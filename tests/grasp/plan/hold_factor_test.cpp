#include "grasp/plan/hold_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "grasp/grippers/suction_cup.h"
#include "scenes/objects/contact.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/grasp/plan/plan_fixture.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A bar of 0.4 kg, 20 cm long in z, and a cup on its upper end.
class HoldFactorTest : public testing::Test {
 protected:
  double At(double tilt_rad, double lift_load) const {
    Pose X_WO = Pose::Identity();
    X_WO.rotate(Eigen::AngleAxisd(tilt_rad, Vector3d(1, 1, 0).normalized()));
    return HoldFactor(cup_, *bar_, X_OG_, X_WO, lift_load);
  }

  SuctionCup cup_ = [] {
    SuctionCup cup;
    cup.cup.press_m = 0;
    return cup;
  }();
  std::shared_ptr<const ObjectModel> bar_ = BoxObject({0.04, 0.04, 0.2}, 0.4);
  Pose X_OG_ = MakePose(Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), {0, 0, 0.1});
  const double weight_n_ = 0.4 * kGravity_mps2;
};

TEST_F(HoldFactorTest, HangingObjectOnlyPulls) {
  const double share = 2 * weight_n_ / cup_.cup.vacuum_n;
  EXPECT_NEAR(At(0, 2), 1 / (1 + std::pow(share, 4)), 1e-9);
}

// The lip is a ring that tips off at the moment limit without a pull. Pull and bending add up.
TEST_F(HoldFactorTest, TiltedObjectBendsTheLip) {
  const double tilt_rad = std::numbers::pi / 3;
  const double ring_m = cup_.cup.moment_limit_nm / cup_.cup.vacuum_n;
  const double bend_n = weight_n_ * 0.1 * std::sin(tilt_rad) / ring_m;
  const double share = 2 * (weight_n_ * std::cos(tilt_rad) + bend_n) / cup_.cup.vacuum_n;
  ASSERT_LT(ring_m, cup_.cup.radius_m);
  EXPECT_GT(share, 1);
  EXPECT_NEAR(At(tilt_rad, 2), 1 / (1 + std::pow(share, 4)), 1e-9);
}

TEST_F(HoldFactorTest, FallsWithTheTiltAndIsOneHalfAtTheLimit) {
  double last = At(0, 2);
  for (double tilt_rad = 0.2; tilt_rad < 1.5; tilt_rad += 0.2) {
    const double factor = At(tilt_rad, 2);
    EXPECT_LT(factor, last) << tilt_rad;
    last = factor;
  }
  EXPECT_NEAR(At(0, cup_.cup.vacuum_n / weight_n_), 0.5, 1e-9);
  EXPECT_EQ(At(1, 0), 1);
}

TEST_F(HoldFactorTest, JawsAreRatedByTheirCandidatesOnly) {
  EXPECT_EQ(HoldFactor(SmallJaw(), *bar_, X_OG_, Pose::Identity(), 10), 1);
}

// The planner uses the factor: a candidate at the center of mass comes before an equal candidate at
// the end of the object.
class HoldFactorPlan : public PlanFixture {};

TEST_F(HoldFactorPlan, CupNearTheCenterOfMassIsFirst) {
  SuctionCup cup;
  cup.name = "cup";
  selected_gripper_ = &cup;
  objects_ = {BoxObject({0.3, 0.05, 0.05}, 0.8)};
  candidates_ = {{}};
  for (const double x_m : {0.1, 0.0}) {
    GraspCandidate candidate;
    candidate.X_OG = MakePose(Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), {x_m, 0, 0.025});
    candidate.quality = 1;
    candidate.epsilon = 1;
    candidates_[0].push_back(candidate);
  }
  AddPose({0, 0, 0.025});
  const PlanResult plan = Run();
  ASSERT_EQ(plan.grasps.size(), 2u);
  EXPECT_NEAR(plan.grasps[0].X_WG.translation().x(), 0, 1e-9);
  EXPECT_LT(plan.grasps[1].score, 0.5 * plan.grasps[0].score);
  const PlanResult ignored = Run({.lift_load = 0});
  EXPECT_NEAR(ignored.grasps[1].score, ignored.grasps[0].score, 1e-9);
}

}  // namespace
}  // namespace pickbed::tests
