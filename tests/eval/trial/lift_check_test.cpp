// Settings of the policy that restrict or order the planned grasps.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/trial/trial.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

TrialResult RunWithClearance(bool check_lift, double clearance_mm) {
  ScenarioSpec spec = CubeScenario(4);
  spec.policy.check_lift = check_lift;
  spec.policy.lift_clearance_mm = clearance_mm;
  return TrialRunner(spec, EasyCube()).Run(BinIndex{0});
}

// No object fits into the 2 mm that remain between the walls.
TEST(LiftCheck, RejectsEveryCandidateOfAnObjectNearAWall) {
  const TrialResult none = RunWithClearance(true, 149);
  ASSERT_EQ(none.attempts.size(), 1u);
  EXPECT_FALSE(none.attempts[0].grasp.has_value());
  EXPECT_EQ(none.ended_by, FailureReason::kNoGrasp);
  EXPECT_GT(none.attempts[0].grasps_rejected.at("held object meets a wall"), 0);
}

TEST(LiftCheck, ChangesNothingIfOffOrWithoutAWallInTheWay) {
  const TrialResult off = RunWithClearance(false, 149), free = RunWithClearance(true, -100);
  EXPECT_EQ(off.instances_cleared, 4);
  ASSERT_EQ(off.attempts.size(), free.attempts.size());
  for (size_t i = 0; i < off.attempts.size(); ++i) {
    EXPECT_EQ(off.attempts[i].hashes, free.attempts[i].hashes);
  }
}

TEST(TolerancePolicy, NeedsAMapOfEachObject) {
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.ranking = "tolerance";
  const auto run = [&] { TrialRunner(spec, EasyCube()); };
  EXPECT_THAT(ErrorOf(run), testing::HasSubstr("make them with pickbed tolerance OBJECT GRIPPER"));
  spec.policy.tolerance_maps = "/no/such/folder";
  EXPECT_THAT(ErrorOf(run), testing::HasSubstr("policy.tolerance_maps: tolerance map /no/such"));
}

}  // namespace
}  // namespace pickbed::tests
