#include "eval/trial/trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "eval/cell/simulated_cell.h"
#include "eval/summary/failure_budget.h"
#include "eval/summary/run_csv.h"
#include "eval/summary/run_summary.h"
#include "scenes/base/error.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

TrialResult RunOne(const ScenarioSpec& spec, const ObjectSet& objects, int trial = 0) {
  return TrialRunner(spec, objects).Run(BinIndex(trial));
}

// Only its edge could be held, which rests on the floor.
ObjectSet WidePlate() { return {BoxObject({0.12, 0.11, 0.006}, 0.2)}; }

// All measured values as text.
std::string Record(const TrialResult& result, const ObjectSet& objects) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  return TrialsCsv({result}) + AttemptsCsv({result}, names);
}

TEST(Trial, GroundTruthPosesOfEasyObjectsEmptyTheBin) {
  const TrialResult result = RunOne(CubeScenario(4), EasyCube());
  EXPECT_EQ(result.instances_dropped, 4);
  EXPECT_EQ(result.instances_cleared, 4);
  EXPECT_EQ(result.ended_by, FailureReason::kNone);
  ASSERT_EQ(result.attempts.size(), 4u);
  std::set<int> picked;
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_EQ(attempt.failure, FailureReason::kNone);
    ASSERT_TRUE(attempt.grasp.has_value());
    EXPECT_EQ(attempt.outcome.picked_instance, attempt.hypotheses.at(attempt.chosen).instance);
    EXPECT_EQ(attempt.instances.size(), 4u - attempt.attempt)
        << "one instance fewer in each attempt";
    picked.insert(attempt.outcome.picked_instance);
  }
  EXPECT_EQ(picked.size(), 4u) << "each instance once";
}

// Cubes on the floor raise the mean surface by their volume over the area of the floor.
TEST(Trial, FillLevelFallsByTheVolumeOfEachPickedCube) {
  const TrialResult result = RunOne(CubeScenario(4), EasyCube());
  const Eigen::Vector3d bin_m = CubeScenario(4).bin.inner_size_m;
  const double of_cube = std::pow(0.03, 3) / bin_m.prod();
  ASSERT_EQ(result.attempts.size(), 4u);
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_NEAR(attempt.fill_level, of_cube * static_cast<double>(attempt.instances.size()),
                0.1 * of_cube);
    EXPECT_EQ(attempt.layer, 1);
    EXPECT_EQ(attempt.instances_above, 0);
    EXPECT_EQ(attempt.instances_below, 0);
  }
}

TEST(Trial, ClutterIsMeasuredBeforeTheFirstPick) {
  const TrialResult result = RunOne(CubeScenario(4), EasyCube());
  EXPECT_EQ(result.layers, std::vector<int>{4});
  EXPECT_EQ(result.instances_tested, 4);
  EXPECT_EQ(result.instances_graspable, 4);
  const TrialResult plate = RunOne(CubeScenario(1), WidePlate());
  EXPECT_EQ(plate.layers, std::vector<int>{1});
  EXPECT_EQ(plate.instances_tested, 1);
  EXPECT_EQ(plate.instances_graspable, 0);
}

TEST(Trial, DependsOnlyOnSeedAndTrialNumber) {
  ScenarioSpec spec = CubeScenario(3);
  spec.estimator.noise_mm = 2;
  spec.estimator.noise_deg = 3;
  const ObjectSet objects = EasyCube();
  TrialRunner runner(spec, objects);
  const std::string zero = Record(runner.Run(BinIndex{0}), objects);
  const std::string one = Record(runner.Run(BinIndex{1}), objects);
  EXPECT_NE(zero, one);
  EXPECT_EQ(Record(runner.Run(BinIndex{0}), objects), zero) << "earlier trials have no effect";
  EXPECT_EQ(Record(RunOne(spec, objects, 1), objects), one) << "the runner keeps no state";
  spec.seed = 12;
  EXPECT_NE(Record(RunOne(spec, objects), objects), zero);
}

TEST(Trial, PolicyLimitsThePicks) {
  ScenarioSpec spec = CubeScenario(3);
  spec.policy.stop = "one_pick";
  const TrialResult one = RunOne(spec, EasyCube());
  EXPECT_EQ(one.attempts.size(), 1u);
  EXPECT_EQ(BudgetOfInstances({&one, 1}).not_asked, 2);
  // A bin without a grasp also requests one instance.
  const TrialResult none = RunOne(spec, WidePlate());
  EXPECT_EQ(BudgetOfInstances({&none, 1})[FailureReason::kNoGrasp], 1);
  EXPECT_EQ(BudgetOfInstances({&none, 1}).asked(), 1);
  spec.policy.stop = "until_empty";
  spec.policy.max_attempts = 2;
  const TrialResult result = RunOne(spec, EasyCube());
  EXPECT_EQ(result.attempts.size(), 2u);
  EXPECT_EQ(result.ended_by, FailureReason::kNone);
  EXPECT_EQ(result.instances_cleared, 2);
}

TEST(Trial, InstanceOutOfReachEndsTheTrialWithoutAGrasp) {
  const TrialResult result = RunOne(CubeScenario(1), WidePlate());
  EXPECT_EQ(result.ended_by, FailureReason::kNoGrasp);
  ASSERT_EQ(result.attempts.size(), 1u);
  EXPECT_FALSE(result.attempts[0].grasp.has_value());
  EXPECT_EQ(result.attempts[0].failure, FailureReason::kNoGrasp);
  EXPECT_EQ(result.instances_cleared, 0);
}

// A bin without a grasp is stirred as often as the policy allows. Each stir counts as a failed pick
// and costs a motion.
TEST(Trial, StirsAreCountedAndPricedAsFailedPicks) {
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.max_failures_in_row = 5;
  spec.policy.stir.max = 2;
  const TrialResult result = RunOne(spec, WidePlate());
  ASSERT_EQ(result.attempts.size(), 3u);
  for (int i : {0, 1}) {
    EXPECT_EQ(result.attempts[i].failure, FailureReason::kStirred);
    EXPECT_FALSE(result.attempts[i].grasp);
    EXPECT_TRUE(UsedHand(result.attempts[i]));
  }
  EXPECT_EQ(result.ended_by, FailureReason::kNoGrasp);
  // A stir whose physics fails counts as one, too.
  AttemptRecord exploded = result.attempts[0];
  exploded.failure = exploded.outcome.failure = FailureReason::kPhysicsFailed;
  EXPECT_TRUE(UsedHand(exploded));
  RunSummary summary = Summarize({result});
  EXPECT_EQ(summary.executed_grasps, 2);
  EXPECT_EQ(summary.successes, 0);
  EXPECT_EQ(summary.failures["stirred"], 2);
  // Price: the motions of two grasps, for one instance that a third attempt would pick.
  TrialResult picked = result;
  picked.attempts[2].grasp = Grasp();
  picked.attempts[2].failure = FailureReason::kNone;
  picked.instances_cleared = 1;
  EXPECT_DOUBLE_EQ(CycleTimeOf({&picked, 1}, {.move_s = 6}).move_s, 18);
  EXPECT_EQ(Record(RunOne(spec, WidePlate()), WidePlate()), Record(result, WidePlate()));
}

TEST(Trial, LastAttemptDoesNotStir) {
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.stir.max = 3;
  spec.policy.max_failures_in_row = 2;
  for (const int max_attempts : {0, 2}) {
    spec.policy.max_attempts = max_attempts;
    const TrialResult result = RunOne(spec, WidePlate());
    ASSERT_EQ(result.attempts.size(), 2u);
    EXPECT_EQ(result.attempts[0].failure, FailureReason::kStirred);
    EXPECT_EQ(result.attempts[1].failure, FailureReason::kNoGrasp);
    EXPECT_EQ(result.ended_by, FailureReason::kNoGrasp);
    spec.policy.max_failures_in_row = 9;
  }
}

TEST(Trial, StirWaitsForConsecutiveAttemptsWithoutAGrasp) {
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.max_failures_in_row = 9;
  spec.policy.stir.max = 1;
  spec.policy.stir.after = 3;
  const TrialResult result = RunOne(spec, WidePlate());
  ASSERT_GE(result.attempts.size(), 3u);
  EXPECT_EQ(result.attempts[1].failure, FailureReason::kNoGrasp);
  EXPECT_EQ(result.attempts[2].failure, FailureReason::kStirred);
}

// The robot misses the cube by centimetres. Each stir follows two failed grasps.
TEST(Trial, FailedGraspsCauseAStir) {
  ScenarioSpec spec = CubeScenario(1);
  spec.cell.repeatability_mm = 60;
  spec.policy.stop = "capture_again";
  spec.policy.max_failures_in_row = 7;
  spec.policy.stir.max = 2;
  spec.policy.stir.after = 6;
  spec.policy.stir.after_failures = 2;
  const TrialResult result = RunOne(spec, EasyCube());
  int stirs = 0, failed = 0;
  for (const AttemptRecord& attempt : result.attempts) {
    if (attempt.failure == FailureReason::kStirred) {
      EXPECT_FALSE(attempt.grasp);
      EXPECT_EQ(failed, 2);
      ++stirs;
      failed = 0;
    } else {
      failed = attempt.failure == FailureReason::kNone ? 0 : failed + 1;
    }
  }
  EXPECT_EQ(stirs, 2);
  spec.policy.stir.after_failures = 6;
  EXPECT_THAT(ErrorOf([&] { spec.Validate(); }), testing::HasSubstr("policy.stir.after_failures"));
}

// The jaw cannot hold the cube of 9 cm, and the small cup not the other one.
TEST(Trial, EachPickUsesTheToolThatHoldsItsObject) {
  ScenarioSpec spec = CubeScenario(2);
  spec.gripper = std::vector<std::string>{"jaw_4cm", "cup_30mm"};
  ObjectSpec large = spec.objects[0];
  large.name = "large";
  large.count = 1;
  spec.objects[0].count = 1;
  spec.objects.push_back(large);
  auto model = std::make_shared<ObjectModel>(*Cube(0.06, 0.05, 0.6));
  model->name = "large";
  const TrialResult result = RunOne(spec, {EasyCube()[0], model});
  EXPECT_EQ(result.instances_cleared, 2);
  for (const AttemptRecord& attempt : result.attempts) {
    ASSERT_TRUE(attempt.grasp);
    const HypothesisRecord& chosen = attempt.hypotheses.at(attempt.chosen);
    if (chosen.object == ObjectId{1}) {
      EXPECT_EQ(attempt.grasp->tool, "cup_30mm");
    }
  }
}

TEST(Trial, ToolChangesCostTime) {
  TrialResult result;
  result.instances_cleared = 4;
  for (const char* tool : {"a", "a", "b", "a"}) {
    result.attempts.emplace_back().grasp = Grasp();
    result.attempts.back().grasp->tool = tool;
  }
  const CycleTime time = CycleTimeOf({&result, 1}, {.move_s = 6, .tool_change_s = 4});
  EXPECT_EQ(time.tool_changes, 2);
  EXPECT_DOUBLE_EQ(time.move_s, 6 + 2 * 4.0 / 4);
}

TEST(Trial, InstancesWithoutAPixelAreNotVisible) {
  // From low outside the bin, a wall occludes everything on the floor.
  ScenarioSpec spec = CubeScenario(2);
  spec.bin.inner_size_m = {0.3, 0.3, 0.25};
  spec.camera.eye_m = {0, -0.8, 0.15};
  spec.camera.target_m = {0, 0, 0.1};
  const TrialResult result = RunOne(spec, EasyCube());
  EXPECT_EQ(result.ended_by, FailureReason::kNotVisible);
  ASSERT_EQ(result.attempts.size(), 1u);
  for (const InstanceRecord& instance : result.attempts[0].instances) {
    EXPECT_EQ(instance.visible_fraction, 0);
  }
}

TEST(Trial, FailureAtAWrongPoseIsAttributedToThePose) {
  ScenarioSpec spec = CubeScenario(2);
  spec.estimator.noise_mm = 60;
  int wrong = 0;
  const ObjectSet objects = EasyCube();
  TrialRunner runner(spec, objects);
  for (int trial = 0; trial < 4; ++trial) {
    for (const AttemptRecord& attempt : runner.Run(BinIndex(trial)).attempts) {
      if (!attempt.grasp || attempt.outcome.success) continue;
      if (attempt.hypotheses.at(attempt.chosen).correct) continue;
      EXPECT_EQ(attempt.failure, FailureReason::kPoseWrong);
      ++wrong;
    }
  }
  EXPECT_GE(wrong, 2) << "the case did not occur";
}

TEST(Trial, TooHeavyInstanceSlipsAndItsGraspIsNotRepeated) {
  // Friction holds 2 * 0.2 * 40 N = 16 N. The cube weighs 49 N.
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.max_failures_in_row = 4;
  const TrialOptions options;
  const TrialResult result = RunOne(spec, {Cube(0.05, 5, 0.2)});
  EXPECT_EQ(result.instances_cleared, 0);
  ASSERT_GE(result.attempts.size(), 2u);
  EXPECT_EQ(result.ended_by, result.attempts.back().failure);
  EXPECT_EQ(result.attempts[0].failure, FailureReason::kSlipped);
  for (size_t a = 0; a < result.attempts.size(); ++a) {
    for (size_t b = a + 1; b < result.attempts.size(); ++b) {
      if (!result.attempts[b].grasp) continue;
      const Pose& first = result.attempts[a].grasp->X_WG;
      const Pose& later = result.attempts[b].grasp->X_WG;
      const double angle = std::acos(first.linear().col(2).dot(later.linear().col(2)));
      const double moved_m = (first.translation() - later.translation()).norm();
      EXPECT_TRUE(angle > options.retry_angle_rad || moved_m > options.retry_radius_m / 2);
    }
  }
}

// A failed grasp stays last in the order even after another instance was picked.
TEST(Trial, FailedGraspIsRepeatedOnlyWhenNoOtherIsLeft) {
  ScenarioSpec spec = CubeScenario(4);
  spec.objects.push_back(spec.objects[0]);
  spec.objects[1].count = 1;
  spec.policy.max_failures_in_row = 3;
  // The large cube slips. It is tried first, since it is the highest and not much too heavy.
  const ObjectSet objects{Cube(0.03, 1.6, 0.6), Cube(0.05, 2.5, 0.2)};
  const TrialOptions options;
  const auto is_near = [&](const AttemptRecord& a, const AttemptRecord& b) {
    const Pose &first = a.grasp->X_WG, &later = b.grasp->X_WG;
    const double angle = std::acos(first.linear().col(2).dot(later.linear().col(2)));
    const double moved_m = (first.translation() - later.translation()).norm();
    return angle < options.retry_angle_rad && moved_m < options.retry_radius_m / 2;
  };
  TrialRunner runner(spec, objects);
  int chances = 0;  // attempts after a failure and a later pick, with small cubes left
  for (int trial = 0; trial < 9; ++trial) {
    const TrialResult result = runner.Run(BinIndex(trial));
    std::vector<AttemptRecord> failed;
    int picked = 0, picked_since = 0;
    for (const AttemptRecord& attempt : result.attempts) {
      if (!attempt.grasp) continue;
      for (const AttemptRecord& old : failed) {
        EXPECT_TRUE(!is_near(old, attempt) || picked == 4) << "trial " << trial;
      }
      chances += picked_since > 0 && picked < 4;
      picked += attempt.outcome.success;
      picked_since += attempt.outcome.success && !failed.empty();
      if (!attempt.outcome.success) failed.push_back(attempt);
    }
  }
  EXPECT_GT(chances, 2) << "the case did not occur";
}

// All sides are wider than the stroke of this jaw, but a wider one can hold the cube. It is
// accepted as a distractor.
TEST(Trial, ObjectWithoutAnyGraspIsRefusedBeforeTheFirstTrial) {
  ScenarioSpec spec = CubeScenario(1);
  const ObjectSet wide{Cube(0.09, 0.2, 0.6)};
  EXPECT_THAT(ErrorOf([&] { TrialRunner(spec, wide); }),
              testing::AllOf(testing::HasSubstr("gripper: object 'cube' has no"),
                             testing::HasSubstr("but jaw_14cm has ")));
  spec.objects.push_back(spec.objects[0]);
  spec.objects[0].distractor = true;
  EXPECT_NO_THROW(TrialRunner(spec, {wide[0], EasyCube()[0]}));
}

TEST(Trial, UnknownNamesAreRefused) {
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

// Attempts without a grasp are failures, and the third in a row ends the trial.
TEST(Trial, CaptureAgainPolicyCountsAttemptsWithoutAGrasp) {
  ScenarioSpec spec = CubeScenario(1);
  spec.policy.stop = "capture_again";
  spec.policy.max_failures_in_row = 3;
  const TrialResult result = RunOne(spec, WidePlate());
  EXPECT_EQ(result.attempts.size(), 3u);
  EXPECT_EQ(result.ended_by, FailureReason::kNoGrasp);
}

FailureBudget Both(const TrialResult& trial) {
  FailureBudget sum = BudgetOfAttempts({&trial, 1});
  const FailureBudget instances = BudgetOfInstances({&trial, 1});
  for (size_t i = 0; i < sum.failures.size(); ++i) sum.failures[i] += instances.failures[i];
  return sum;
}

// The pose error of the oracle is between a tenth and half of the diameter. Ground truth is then
// substituted for single stages.
TEST(Trial, GroundTruthForAStageRemovesItsFailures) {
  ScenarioSpec spec = CubeScenario(4);
  spec.estimator.noise_mm = 8;
  const ObjectSet objects = EasyCube();
  const auto run = [&](const OracleStages& truth) {
    TrialOptions options;
    options.truth = truth;
    TrialRunner runner(spec, objects, {}, options);
    FailureBudget sum;
    for (int trial = 0; trial < 3; ++trial) {
      const FailureBudget one = Both(runner.Run(BinIndex(trial)));
      sum.total += one.total;
      sum.picked += one.picked;
      for (size_t i = 0; i < sum.failures.size(); ++i) sum.failures[i] += one.failures[i];
    }
    return sum;
  };
  const FailureBudget as_run = run({});
  EXPECT_GT(as_run[FailureReason::kPoseWrong], 0) << "the case did not occur";
  const FailureBudget pose = run({.pose = true});
  EXPECT_EQ(pose[FailureReason::kPoseWrong], 0);
  EXPECT_EQ(pose.picked, 12);
  EXPECT_EQ(run({.detection = true})[FailureReason::kNoProposal], 0);
  EXPECT_NO_THROW(RequireGraspFailuresOnly(run({true, true, true, true, false})));
}

// From low outside the bin, a wall occludes the floor. With ground truth in all stages, the
// instances are still known.
TEST(Trial, GroundTruthInAllStagesCoversInvisibleInstances) {
  ScenarioSpec spec = CubeScenario(2);
  spec.seed = 12;  // no instance is in a corner
  spec.camera.eye_m = {0, -0.8, 0.1};
  spec.camera.target_m = {0, 0, 0.075};
  EXPECT_EQ(RunOne(spec, EasyCube()).ended_by, FailureReason::kNotVisible);
  TrialOptions options;
  options.truth = OracleNamed("everything").truth;
  const TrialResult result = TrialRunner(spec, EasyCube(), {}, options).Run(BinIndex{0});
  EXPECT_NO_THROW(RequireGraspFailuresOnly(Both(result)));
  EXPECT_EQ(result.instances_cleared, 2);
}

TEST(SimulatedCell, EachAttemptHasNewNoiseAndTheSameGroundTruth) {
  SimulatedCell cell(CubeScenario(3), EasyCube());
  const Scene scene = cell.MakeScene(BinIndex{0}).scene;
  const Observation first = cell.Capture(scene, BinIndex{0}, 0),
                    again = cell.Capture(scene, BinIndex{0}, 0);
  const Observation second = cell.Capture(scene, BinIndex{0}, 1);
  EXPECT_EQ(first.frame.depth_m, again.frame.depth_m);
  EXPECT_NE(first.frame.depth_m, second.frame.depth_m);
  EXPECT_EQ(first.ids, second.ids);
  EXPECT_EQ(first.visible_fractions, second.visible_fractions);
  const std::set<uint16_t> ids(first.ids.pixels().begin(), first.ids.pixels().end());
  EXPECT_EQ(ids, (std::set<uint16_t>{0, 1, 2, 3}));
}

}  // namespace
}  // namespace pickbed::tests
