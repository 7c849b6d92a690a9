// Trials with a planner that works without poses.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "eval/summary/failure_budget.h"
#include "eval/summary/run_csv.h"
#include "eval/summary/run_summary.h"
#include "eval/trial/failure_attribution.h"
#include "eval/trial/grasp_choice.h"
#include "eval/trial/recorded_scene.h"
#include "eval/trial/trial.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

// The estimator does not exist, so a trial that made it would fail.
ScenarioSpec PoseFreeScenario(int count) {
  ScenarioSpec spec = CubeScenario(count);
  spec.planner.name = "cloud_antipodal";
  spec.estimator.name = "none";
  return spec;
}

TrialResult RunPoseFree(const ScenarioSpec& spec, const ObjectSet& objects,
                        const TrialOptions& options = {}) {
  return TrialRunner(spec, objects, {}, options).Run(BinIndex(0));
}

TEST(PoseFreeTrial, EmptiesABinOfCubesWithoutAnEstimator) {
  const TrialResult result = RunPoseFree(PoseFreeScenario(4), EasyCube());
  EXPECT_EQ(result.instances_cleared, 4);
  EXPECT_EQ(result.ended_by, FailureReason::kNone);
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_TRUE(attempt.pose_free);
    EXPECT_TRUE(attempt.hypotheses.empty());
    ASSERT_TRUE(attempt.grasp.has_value());
    EXPECT_EQ(attempt.grasp->hypothesis, kNoHypothesis);
    EXPECT_EQ(attempt.chosen, -1);
    if (attempt.failure != FailureReason::kNone) continue;
    EXPECT_EQ(attempt.matched_instance, attempt.outcome.picked_instance);
    EXPECT_EQ(attempt.outcome.instances_lifted, 1);
  }
  for (const InstanceOutcome& outcome : result.outcomes) EXPECT_TRUE(outcome.picked);
  for (const auto& [stage, seconds] : result.seconds) {
    EXPECT_FALSE(stage.starts_with("estimate")) << stage;
  }
}

TEST(PoseFreeTrial, DependsOnlyOnSeedAndTrialNumber) {
  const ScenarioSpec spec = PoseFreeScenario(3);
  const ObjectSet objects = EasyCube();
  const TrialResult a = RunPoseFree(spec, objects), b = RunPoseFree(spec, objects);
  EXPECT_EQ(AttemptsCsv({a}, {"cube"}), AttemptsCsv({b}, {"cube"}));
  ASSERT_EQ(a.attempts.size(), b.attempts.size());
  for (size_t i = 0; i < a.attempts.size(); ++i)
    EXPECT_EQ(a.attempts[i].hashes, b.attempts[i].hashes);
}

TEST(PoseFreeTrial, NoGraspIsNotAttributedToPoses) {
  const ObjectSet plate{BoxObject({0.12, 0.11, 0.006}, 0.2)};
  const TrialResult result = RunPoseFree(PoseFreeScenario(1), plate);
  ASSERT_EQ(result.attempts.size(), 1u);
  EXPECT_EQ(result.attempts[0].failure, FailureReason::kNoGrasp);
  EXPECT_EQ(BudgetOfInstances({&result, 1})[FailureReason::kNoGrasp], 1);
}

// The executed grasps of a run without a limit say which scores there are.
TEST(PoseFreeTrial, NoGraspUnderTheSmallestScoreIsExecuted) {
  ScenarioSpec spec = PoseFreeScenario(4);
  const TrialResult all = RunPoseFree(spec, EasyCube());
  double best = 0;
  for (const AttemptRecord& attempt : all.attempts) best = std::max(best, attempt.grasp->score);
  spec.planner.min_score = best + 0.001;
  const TrialResult none = RunPoseFree(spec, EasyCube());
  ASSERT_EQ(none.attempts.size(), 1u);
  EXPECT_FALSE(none.attempts[0].grasp.has_value());
  EXPECT_EQ(none.attempts[0].failure, FailureReason::kNoGrasp);
  EXPECT_GT(none.attempts[0].grasps_rejected.at("score too low"), 0);
}

TEST(PoseFreeTrial, ReportsHaveNoRecall) {
  const TrialResult result = RunPoseFree(PoseFreeScenario(2), EasyCube());
  const RunSummary summary = Summarize({result});
  EXPECT_FALSE(summary.has_poses());
  EXPECT_EQ(summary.recall.samples, 0);
  EXPECT_EQ(summary.successes, 2);
  EXPECT_EQ(SummaryTable(summary).find("Recall"), std::string::npos);
  EXPECT_THAT(AttemptsCsv({result}, {"cube"}), HasSubstr(",cube,"));
}

// A recorded trial gives the scene of each attempt again.
TEST(PoseFreeTrial, ScenesOfAttemptsAreReproduced) {
  const ScenarioSpec spec = PoseFreeScenario(3);
  TrialSetup setup(spec, EasyCube(), {}, {});
  const TrialResult result = RunTrial(setup, BinIndex(0));
  ASSERT_GE(result.attempts.size(), 2u);
  const Scene scene = SceneOfAttempt(result, 1, {setup.cell, setup.tools, spec.policy.success});
  EXPECT_EQ(scene.objects.size(), 2u);
}

// With the poses of all instances given, the planner on poses shows what perfect poses are worth.
TEST(PoseFreeTrial, GivenPosesUseThePlannerOnPoses) {
  TrialOptions options;
  options.truth = OracleNamed("perception").truth;
  const TrialResult result = RunPoseFree(PoseFreeScenario(2), EasyCube(), options);
  for (const AttemptRecord& attempt : result.attempts) EXPECT_FALSE(attempt.pose_free);
  EXPECT_EQ(result.instances_cleared, 2);
}

TEST(PoseFreeTrial, GraspsAreTriedInTheTrueScene) {
  TrialOptions options;
  options.truth = OracleNamed("grasp").truth;
  const TrialResult result = RunPoseFree(PoseFreeScenario(2), EasyCube(), options);
  EXPECT_EQ(result.instances_cleared, 2);
}

TEST(PoseFreeTrial, PickedDistractorIsAFailure) {
  ScenarioSpec spec = PoseFreeScenario(1);
  ObjectSpec distractor = spec.objects[0];
  distractor.name = "other";
  distractor.distractor = true;
  distractor.count = 4;
  spec.objects.push_back(distractor);
  spec.policy.max_failures_in_row = 10;
  const ObjectSet objects{EasyCube()[0], EasyCube()[0]};
  const TrialResult result = RunPoseFree(spec, objects);
  int wrong = 0;
  for (const AttemptRecord& attempt : result.attempts) {
    wrong += attempt.failure == FailureReason::kWrongObject;
  }
  EXPECT_GT(wrong, 0);
  EXPECT_LE(result.instances_cleared, 1);
}

TEST(PoseFreeTrial, RefusesSettingsThatNeedPoses) {
  const auto error = [](const std::function<void(ScenarioSpec&)>& change) {
    ScenarioSpec spec = PoseFreeScenario(1);
    change(spec);
    return ErrorOf([&] { PlannerOf(spec, {}); });
  };
  EXPECT_THAT(error([](ScenarioSpec& s) { s.occlusion.enabled = true; }),
              HasSubstr("occlusion.enabled: planner cloud_antipodal works without poses"));
  EXPECT_THAT(error([](ScenarioSpec& s) { s.policy.picks_per_image = 2; }),
              HasSubstr("policy.picks_per_image"));
  EXPECT_THAT(error([](ScenarioSpec& s) { s.policy.check_lift = true; }),
              HasSubstr("policy.check_lift"));
  EXPECT_THAT(error([](ScenarioSpec& s) { s.policy.ranking = "random"; }),
              HasSubstr("policy.ranking"));
  EXPECT_THAT(error([](ScenarioSpec& s) { s.planner.name = "cloud"; }),
              HasSubstr("planner.name: "));
  EXPECT_EQ(error([](ScenarioSpec&) {}), "no error");
  EXPECT_THAT(ErrorOf([] { PlannerOf(PoseFreeScenario(1), OracleNamed("detection").truth); }),
              HasSubstr("choose grasp, perception or everything"));
}

TEST(PoseFreeTrial, PhysicalOutcomeIsTheFailure) {
  AttemptRecord record;
  record.pose_free = true;
  Grasp grasp;
  grasp.hypothesis = kNoHypothesis;
  record.grasp = grasp;
  for (const FailureReason failure :
       {FailureReason::kSlipped, FailureReason::kCollision, FailureReason::kDoublePick,
        FailureReason::kClosedOnNothing}) {
    record.outcome.failure = failure;
    EXPECT_EQ(AttributeFailure(record, {}, 0.5, InstanceMatcher({}, {})), failure);
  }
  record.outcome.success = true;
  EXPECT_EQ(AttributeFailure(record, {}, 0.5, InstanceMatcher({}, {})), FailureReason::kNone);
  record.grasp.reset();
  EXPECT_EQ(AttributeFailure(record, {}, 0.5, InstanceMatcher({}, {})), FailureReason::kNotVisible);
  record.instances = {{InstanceId(0), ObjectId(0), 0.5}};
  EXPECT_EQ(AttributeFailure(record, {}, 0.5, InstanceMatcher({}, {})), FailureReason::kNoGrasp);
}

// A grasp without a pose.
Grasp GraspAt(double x_m) {
  Grasp grasp;
  grasp.hypothesis = kNoHypothesis;
  grasp.X_WG = Translation({x_m, 0, 0.02});
  return grasp;
}

// Without poses, a failure is remembered at the place of the hand.
TEST(PoseFreeTrial, FailedGraspIsNotRepeatedNearItsPlace) {
  GraspMemory memory;
  GraspOutcome failed, picked;
  picked.success = true;
  memory.Remember(GraspAt(0), nullptr, failed);
  const TrialOptions options;
  const std::vector<Grasp> fresh =
      memory.WithoutRepetitions({GraspAt(0.005), GraspAt(0.05)}, {}, options);
  ASSERT_EQ(fresh.size(), 1u);
  EXPECT_EQ(fresh[0].X_WG.translation().x(), 0.05);
  EXPECT_TRUE(memory.WithoutRepetitions({GraspAt(0.005)}, {}, options).empty());
  memory.Remember(GraspAt(0.05), nullptr, picked);
  EXPECT_EQ(memory.WithoutRepetitions({GraspAt(0.005)}, {}, options).size(), 1u)
      << "the way may be clear after a pick";
}

TEST(PoseFreeTrial, AnInstanceThatFailsTwiceComesAfterOthers) {
  const std::vector<Grasp> planned{GraspAt(0.03), GraspAt(0.1), GraspAt(0.2)};
  const TrialOptions options;
  GraspMemory memory;
  memory.Remember(GraspAt(0), nullptr, {});
  EXPECT_EQ(memory.WithoutRepetitions(planned, {}, options)[0].X_WG.translation().x(), 0.03);
  memory.Remember(GraspAt(0.06), nullptr, {});
  const std::vector<Grasp> fresh = memory.WithoutRepetitions(planned, {}, options);
  ASSERT_EQ(fresh.size(), 3u);
  EXPECT_EQ(fresh[0].X_WG.translation().x(), 0.1);
  EXPECT_EQ(fresh[1].X_WG.translation().x(), 0.2);
  EXPECT_EQ(fresh[2].X_WG.translation().x(), 0.03);
}

// With poses, one failure is enough. Another instance of the same kind comes first, and so does
// another kind of object at the same place.
TEST(PoseFreeTrial, AnInstanceWithAPoseComesAfterOthersOnceItFailed) {
  const auto at = [](int object, double x_m) {
    return EstimatedPose{ObjectId{object}, Translation({x_m, 0, 0}), 1};
  };
  const std::vector<EstimatedPose> poses{at(0, 0.03), at(0, 0.1), at(1, 0.03)};
  std::vector<Grasp> planned;
  for (int hypothesis = 0; hypothesis < 3; ++hypothesis) {
    planned.push_back(GraspAt(0));
    planned.back().hypothesis = hypothesis;
  }
  GraspMemory memory;
  const EstimatedPose failed = at(0, 0);
  memory.Remember(GraspAt(0), &failed, {});
  const std::vector<Grasp> fresh = memory.WithoutRepetitions(planned, poses, TrialOptions());
  ASSERT_EQ(fresh.size(), 3u);
  EXPECT_EQ(fresh[0].hypothesis, 1);
  EXPECT_EQ(fresh[1].hypothesis, 2);
  EXPECT_EQ(fresh[2].hypothesis, 0);
}

// Returns the largest number of failed grasps that were near a later executed one.
int FailuresBeforeAnother(const TrialResult& result) {
  GraspMemory memory;
  int largest = 0;
  for (const AttemptRecord& attempt : result.attempts) {
    if (!attempt.grasp) continue;
    largest = std::max(largest, memory.FailuresNear(*attempt.grasp, {}));
    memory.Remember(*attempt.grasp, nullptr, attempt.outcome);
  }
  return largest;
}

TEST(PoseFreeTrial, CountsFailuresNearTheHand) {
  GraspMemory memory;
  memory.Remember(GraspAt(0), nullptr, {});
  memory.Remember(GraspAt(0.02), nullptr, {});
  EXPECT_EQ(memory.FailuresNear(GraspAt(0.01), {}), 2);
  EXPECT_EQ(memory.FailuresNear(GraspAt(0.05), {}), 1);
  EXPECT_EQ(memory.FailuresNear(GraspAt(0.1), {}), 0);
}

// With poses, failures are counted by the place of the object, not of the hand.
TEST(PoseFreeTrial, CountsFailuresNearThePoseOfTheSameObject) {
  const auto at = [](int object, double x_m) {
    return EstimatedPose{ObjectId{object}, Translation({x_m, 0, 0}), 1};
  };
  GraspMemory memory;
  const EstimatedPose failed = at(0, 0);
  memory.Remember(GraspAt(0), &failed, {});
  const std::vector<EstimatedPose> poses{at(0, 0.03), at(0, 0.05), at(1, 0.03)};
  const auto near = [&](int hypothesis) {
    Grasp grasp = GraspAt(0.2);
    grasp.hypothesis = hypothesis;
    return memory.FailuresNear(grasp, poses);
  };
  EXPECT_EQ(near(0), 1);
  EXPECT_EQ(near(1), 0);
  EXPECT_EQ(near(2), 0);
  EXPECT_EQ(memory.FailuresNear(GraspAt(0), poses), 0);
}

// The cube is too heavy to be lifted, so each grasp fails.
TEST(PoseFreeTrial, GivesUpAPlaceAfterTheAllowedFailures) {
  const ObjectSet heavy{BoxObject({0.04, 0.04, 0.04}, 40)};
  ScenarioSpec spec = PoseFreeScenario(1);
  spec.policy.max_failures_in_row = 5;
  EXPECT_GT(FailuresBeforeAnother(RunPoseFree(spec, heavy)), 1);
  spec.policy.max_failures_at_place = 1;
  EXPECT_EQ(FailuresBeforeAnother(RunPoseFree(spec, heavy)), 0);
}

}  // namespace
}  // namespace pickbed::tests
