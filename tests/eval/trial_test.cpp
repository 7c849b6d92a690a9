#include "eval/trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "eval/loss_budget.h"
#include "eval/summary.h"
#include "eval/virtual_cell.h"
#include "scenes/check.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_parts.h"
#include "tests/support/error_of.h"

namespace pickbed {
namespace {

TrialResult RunOne(const ScenarioSpec& spec, const ObjectSet& objects, int trial = 0) {
  return TrialRunner(spec, objects).Run(trial);
}

// It can be held by its edge alone, which lies on the floor.
ObjectSet WidePlate() { return {BoxPart({0.12, 0.11, 0.006}, 0.2)}; }

// All that is measured, as text.
std::string Record(const TrialResult& result, const ObjectSet& objects) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  return TrialsCsv({result}) + PicksCsv({result}, names);
}

TEST(Trial, TruePosesOfEasyPartsEmptyTheBin) {
  const TrialResult result = RunOne(CubeScenario(4), EasyCube());
  EXPECT_EQ(result.parts_dropped, 4);
  EXPECT_EQ(result.parts_cleared, 4);
  EXPECT_EQ(result.ended_by, Loss::kNone);
  ASSERT_EQ(result.picks.size(), 4u);
  std::set<int> picked;
  for (const PickRecord& pick : result.picks) {
    EXPECT_EQ(pick.loss, Loss::kNone);
    ASSERT_TRUE(pick.grasp.has_value());
    EXPECT_EQ(pick.outcome.picked_instance, pick.hypotheses.at(pick.chosen).instance);
    EXPECT_EQ(pick.instances.size(), 4u - pick.pick) << "one part less in every look";
    picked.insert(pick.outcome.picked_instance);
  }
  EXPECT_EQ(picked.size(), 4u) << "each part once";
}

TEST(Trial, IsAFunctionOfSeedAndNumber) {
  ScenarioSpec spec = CubeScenario(3);
  spec.estimator.noise_mm = 2;
  spec.estimator.noise_deg = 3;
  const ObjectSet objects = EasyCube();
  TrialRunner runner(spec, objects);
  const std::string zero = Record(runner.Run(0), objects);
  const std::string one = Record(runner.Run(1), objects);
  EXPECT_NE(zero, one);
  EXPECT_EQ(Record(runner.Run(0), objects), zero) << "what came before does not matter";
  EXPECT_EQ(Record(RunOne(spec, objects, 1), objects), one) << "nor does the runner";
  spec.seed = 12;
  EXPECT_NE(Record(RunOne(spec, objects), objects), zero);
}

TEST(Trial, PolicyLimitsThePicks) {
  ScenarioSpec spec = CubeScenario(3);
  spec.policy.stop = "one_pick";
  const TrialResult one = RunOne(spec, EasyCube());
  EXPECT_EQ(one.picks.size(), 1u);
  EXPECT_EQ(BudgetOfInstances({&one, 1}).not_asked, 2);
  // A bin without a grasp was asked for one part, too.
  const TrialResult none = RunOne(spec, WidePlate());
  EXPECT_EQ(BudgetOfInstances({&none, 1})[Loss::kNoGrasp], 1);
  EXPECT_EQ(BudgetOfInstances({&none, 1}).asked(), 1);
  spec.policy.stop = "until_empty";
  spec.policy.max_picks = 2;
  const TrialResult result = RunOne(spec, EasyCube());
  EXPECT_EQ(result.picks.size(), 2u);
  EXPECT_EQ(result.ended_by, Loss::kNone);
  EXPECT_EQ(result.parts_cleared, 2);
}

TEST(Trial, APartThatLiesOutOfReachEndsWithoutAttempt) {
  const TrialResult result = RunOne(CubeScenario(1), WidePlate());
  EXPECT_EQ(result.ended_by, Loss::kNoGrasp);
  ASSERT_EQ(result.picks.size(), 1u);
  EXPECT_FALSE(result.picks[0].grasp.has_value());
  EXPECT_EQ(result.picks[0].loss, Loss::kNoGrasp);
  EXPECT_EQ(result.parts_cleared, 0);
}

TEST(Trial, PartsThatNoPixelShowsAreNotVisible) {
  // From low outside, a wall hides all that lies on the floor.
  ScenarioSpec spec = CubeScenario(2);
  spec.bin.inner_size_m = {0.3, 0.3, 0.25};
  spec.camera.eye_m = {0, -0.8, 0.15};
  spec.camera.target_m = {0, 0, 0.1};
  const TrialResult result = RunOne(spec, EasyCube());
  EXPECT_EQ(result.ended_by, Loss::kNotVisible);
  ASSERT_EQ(result.picks.size(), 1u);
  for (const InstanceRecord& instance : result.picks[0].instances) {
    EXPECT_EQ(instance.visible_fraction, 0);
  }
}

TEST(Trial, AWrongPoseIsBlamedAndNotPhysics) {
  ScenarioSpec spec = CubeScenario(2);
  spec.estimator.noise_mm = 60;
  int wrong = 0;
  const ObjectSet objects = EasyCube();
  TrialRunner runner(spec, objects);
  for (int trial = 0; trial < 4; ++trial) {
    for (const PickRecord& pick : runner.Run(trial).picks) {
      if (!pick.grasp || pick.outcome.success) continue;
      if (pick.hypotheses.at(pick.chosen).correct) continue;
      EXPECT_EQ(pick.loss, Loss::kPoseWrong);
      ++wrong;
    }
  }
  EXPECT_GE(wrong, 2) << "the case did not occur";
}

TEST(Trial, ATooHeavyPartIsLostToPhysicsAndTheSameGraspIsNotRepeated) {
  // 2 * 0.2 * 40 N hold 16 N; the cube weighs 49 N.
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.max_failures_in_row = 4;
  const TrialOptions options;
  const TrialResult result = RunOne(spec, {Cube(0.05, 5, 0.2)});
  EXPECT_EQ(result.parts_cleared, 0);
  ASSERT_GE(result.picks.size(), 2u);
  EXPECT_EQ(result.ended_by, result.picks.back().loss);
  EXPECT_EQ(result.picks[0].loss, Loss::kSlipped);
  for (size_t a = 0; a < result.picks.size(); ++a) {
    for (size_t b = a + 1; b < result.picks.size(); ++b) {
      if (!result.picks[b].grasp) continue;
      const Pose& first = result.picks[a].grasp->X_WG;
      const Pose& later = result.picks[b].grasp->X_WG;
      const double angle = std::acos(first.linear().col(2).dot(later.linear().col(2)));
      const double moved_m = (first.translation() - later.translation()).norm();
      EXPECT_TRUE(angle > options.retry_angle_rad || moved_m > options.retry_radius_m / 2);
    }
  }
}

// A pick of another part does not make a grasp good that failed: it comes last.
TEST(Trial, AFailedGraspIsRepeatedOnlyWhenNothingElseIsLeft) {
  ScenarioSpec spec = CubeScenario(4);
  spec.objects.push_back(spec.objects[0]);
  spec.objects[1].count = 1;
  spec.policy.max_failures_in_row = 3;
  const ObjectSet objects{Cube(0.03, 0.05, 0.6), Cube(0.05, 5, 0.2)};
  const TrialOptions options;
  const auto is_near = [&](const PickRecord& a, const PickRecord& b) {
    const Pose &first = a.grasp->X_WG, &later = b.grasp->X_WG;
    const double angle = std::acos(first.linear().col(2).dot(later.linear().col(2)));
    const double moved_m = (first.translation() - later.translation()).norm();
    return angle < options.retry_angle_rad && moved_m < options.retry_radius_m / 2;
  };
  TrialRunner runner(spec, objects);
  int chances = 0;  // looks at light cubes after the heavy one was tried and another was picked
  for (int trial = 0; trial < 6; ++trial) {
    const TrialResult result = runner.Run(trial);
    std::vector<PickRecord> failed;
    int picked = 0, picked_since = 0;
    for (const PickRecord& pick : result.picks) {
      if (!pick.grasp) continue;
      for (const PickRecord& old : failed) {
        EXPECT_TRUE(!is_near(old, pick) || picked == 4) << "trial " << trial;
      }
      chances += picked_since > 0 && picked < 4;
      picked += pick.outcome.success;
      picked_since += pick.outcome.success && !failed.empty();
      if (!pick.outcome.success) failed.push_back(pick);
    }
  }
  EXPECT_GT(chances, 2) << "the case did not occur";
}

// All its sides are wider than the hand opens; a cup can hold it. As a foreign part it may be so.
TEST(Trial, APartWithoutAnyGraspIsSaidBeforeTheFirstTrial) {
  ScenarioSpec spec = CubeScenario(1);
  const ObjectSet wide{Cube(0.09, 0.2, 0.6)};
  EXPECT_THAT(ErrorOf([&] { TrialRunner(spec, wide); }),
              testing::AllOf(testing::HasSubstr("gripper: part 'cube' has no"),
                             testing::HasSubstr("cup_30mm has")));
  spec.objects.push_back(spec.objects[0]);
  spec.objects[0].foreign = true;
  EXPECT_NO_THROW(TrialRunner(spec, {wide[0], EasyCube()[0]}));
}

TEST(Trial, UnknownNamesAreBadInput) {
  for (const auto& spoil : std::vector<std::function<void(ScenarioSpec&)>>{
           [](ScenarioSpec& s) { s.estimator.name = "orcale"; },
           [](ScenarioSpec& s) { s.gripper = "jaw_9cm"; },
           [](ScenarioSpec& s) { s.sensor = "eye"; },
           [](ScenarioSpec& s) { s.policy.stop = "never"; }}) {
    ScenarioSpec spec = CubeScenario(1);
    spoil(spec);
    EXPECT_THROW(TrialRunner(spec, EasyCube()), InputError);
  }
}

// The looks that find no grasp are failures like others, and the third of them ends the trial.
TEST(Trial, ThePolicyThatLooksAgainCountsLooksWithoutGrasp) {
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.stop = "look_again";
  spec.policy.max_failures_in_row = 3;
  const TrialResult result = RunOne(spec, WidePlate());
  EXPECT_EQ(result.picks.size(), 3u);
  EXPECT_EQ(result.ended_by, Loss::kNoGrasp);
}

LossBudget Both(const TrialResult& trial) {
  LossBudget sum = BudgetOfAttempts({&trial, 1});
  const LossBudget instances = BudgetOfInstances({&trial, 1});
  for (size_t i = 0; i < sum.lost.size(); ++i) sum.lost[i] += instances.lost[i];
  return sum;
}

// An oracle that is off by more than a tenth of the diameter and less than half of it, and stages
// that are then fed with truth.
TEST(Trial, TruthInPlaceOfAStageMendsThatStage) {
  ScenarioSpec spec = CubeScenario(4);
  spec.estimator.noise_mm = 8;
  const ObjectSet objects = EasyCube();
  const auto run = [&](const TruthStages& truth) {
    TrialOptions options;
    options.truth = truth;
    TrialRunner runner(spec, objects, {}, options);
    LossBudget sum;
    for (int trial = 0; trial < 3; ++trial) {
      const LossBudget one = Both(runner.Run(trial));
      sum.total += one.total;
      sum.picked += one.picked;
      for (size_t i = 0; i < sum.lost.size(); ++i) sum.lost[i] += one.lost[i];
    }
    return sum;
  };
  const LossBudget as_run = run({});
  EXPECT_GT(as_run[Loss::kPoseWrong], 0) << "the case did not occur";
  const LossBudget pose = run({.pose = true});
  EXPECT_EQ(pose[Loss::kPoseWrong], 0);
  EXPECT_EQ(pose.picked, 12);
  EXPECT_EQ(run({.detection = true})[Loss::kNoProposal], 0);
  EXPECT_NO_THROW(RequireGraspLossesOnly(run({true, true, true, true, false})));
}

// From low outside, a wall hides what lies on the floor: with truth everywhere it is known.
TEST(Trial, TruthEverywhereKnowsWhatNoPixelShows) {
  ScenarioSpec spec = CubeScenario(2);
  spec.seed = 12;  // neither part in a corner
  spec.camera.eye_m = {0, -0.8, 0.1};
  spec.camera.target_m = {0, 0, 0.075};
  EXPECT_EQ(RunOne(spec, EasyCube()).ended_by, Loss::kNotVisible);
  TrialOptions options;
  options.truth = OracleNamed("everything").truth;
  const TrialResult result = TrialRunner(spec, EasyCube(), {}, options).Run(0);
  EXPECT_NO_THROW(RequireGraspLossesOnly(Both(result)));
  EXPECT_EQ(result.parts_cleared, 2);
}

TEST(VirtualCell, EveryLookIsANewSampleOfTheSameTruth) {
  VirtualCell cell(CubeScenario(3), EasyCube());
  const Scene scene = cell.MakeScene(0).scene;
  const View first = cell.See(scene, 0, 0), again = cell.See(scene, 0, 0);
  const View second = cell.See(scene, 0, 1);
  EXPECT_EQ(first.frame.depth_m, again.frame.depth_m);
  EXPECT_NE(first.frame.depth_m, second.frame.depth_m);
  EXPECT_EQ(first.ids, second.ids);
  EXPECT_EQ(first.visible_fractions, second.visible_fractions);
  const std::set<uint16_t> ids(first.ids.pixels().begin(), first.ids.pixels().end());
  EXPECT_EQ(ids, (std::set<uint16_t>{0, 1, 2, 3}));
}

}  // namespace
}  // namespace pickbed
