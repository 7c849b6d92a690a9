// Trials that run attempt by attempt, with grasps that the caller chooses.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/summary/run_csv.h"
#include "eval/sweep/run.h"
#include "eval/trial/attempt.h"
#include "eval/trial/trial.h"
#include "scenes/base/files.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

class PickingTrialTest : public testing::Test {
 protected:
  explicit PickingTrialTest(int count = 3) : spec_(CubeScenario(count)) {}
  TrialSetup Setup(const TrialOptions& options = {}) { return {spec_, EasyCube(), {}, options}; }

  ScenarioSpec spec_;
};

std::vector<StageHashes> HashesOf(const TrialResult& result) {
  std::vector<StageHashes> hashes;
  for (const AttemptRecord& attempt : result.attempts) hashes.push_back(attempt.hashes);
  return hashes;
}

TEST_F(PickingTrialTest, ChosenGraspsGiveTheTrialOfRunTrial) {
  TrialSetup setup = Setup();
  PickingTrial trial(setup, BinIndex(1));
  while (!trial.HasEnded()) {
    const std::optional<Grasp> grasp = trial.Attempt().ChooseGrasp();
    EXPECT_TRUE(trial.Attempt().IsChosen(grasp));
    trial.Execute(grasp);
  }
  const TrialResult result = trial.TakeResult();
  const TrialResult expected = RunTrial(setup, BinIndex(1));
  EXPECT_EQ(HashesOf(result), HashesOf(expected));
  EXPECT_EQ(result.instances_cleared, expected.instances_cleared);
  EXPECT_GT(result.instances_cleared, 0);
}

TEST_F(PickingTrialTest, GraspWithoutHypothesisIsJudgedByTheInstanceThatComes) {
  TrialSetup setup = Setup();
  for (const bool with_estimate : {false, true}) {
    PickingTrial trial(setup, BinIndex(0));
    Grasp grasp = trial.Attempt().ChooseGrasp().value();
    PickingTrial own(setup, BinIndex(0));
    if (with_estimate) own.Attempt().Estimate();
    grasp.hypothesis = kNoHypothesis;
    EXPECT_FALSE(own.Attempt().IsChosen(grasp));
    const AttemptRecord record = own.Execute(grasp);
    EXPECT_TRUE(record.pose_free);
    EXPECT_TRUE(record.hypotheses.empty());
    EXPECT_EQ(record.failure, FailureReason::kNone);
    EXPECT_EQ(record.matched_instance, record.outcome.picked_instance);
    EXPECT_EQ(record.instances.size(), 3u);
    for (const InstanceRecord& instance : record.instances) {
      EXPECT_FALSE(instance.recalled);
      EXPECT_EQ(instance.missed, FailureReason::kNone);
    }
  }
}

TEST_F(PickingTrialTest, RefusedGraspLeavesTheAttemptAsItWas) {
  TrialSetup setup = Setup();
  PickingTrial trial(setup, BinIndex(0));
  Grasp grasp;
  grasp.hypothesis = 0;
  EXPECT_THAT(ErrorOf([&] { trial.Execute(grasp); }), HasSubstr("the attempt has 0 hypotheses"));
  grasp.hypothesis = kNoHypothesis;
  grasp.tool = "claw";
  EXPECT_THAT(ErrorOf([&] { trial.Execute(grasp); }), HasSubstr("'claw'"));
  while (!trial.HasEnded()) trial.Execute(trial.Attempt().ChooseGrasp());
  EXPECT_EQ(HashesOf(trial.TakeResult()), HashesOf(RunTrial(setup, BinIndex(0))));
}

TEST_F(PickingTrialTest, AttemptsWithoutAGraspEndTheTrial) {
  TrialSetup setup = Setup();
  PickingTrial trial(setup, BinIndex(0));
  const size_t before = trial.scene().objects.size();
  EXPECT_EQ(trial.Execute(std::nullopt).failure, FailureReason::kNoGrasp);
  while (!trial.HasEnded()) trial.Execute(std::nullopt);
  EXPECT_FALSE(trial.HasReachedLimit());
  EXPECT_EQ(trial.scene().objects.size(), before);
  EXPECT_THROW(trial.Attempt(), std::logic_error);
  const TrialResult result = trial.TakeResult();
  EXPECT_EQ(result.ended_by, FailureReason::kNoGrasp);
  for (const InstanceOutcome& outcome : result.outcomes) EXPECT_FALSE(outcome.picked);
}

TEST_F(PickingTrialTest, LimitOfAttemptsIsNoFailure) {
  spec_.policy.max_attempts = 1;
  TrialSetup setup = Setup();
  PickingTrial trial(setup, BinIndex(0));
  trial.Execute(trial.Attempt().ChooseGrasp());
  EXPECT_TRUE(trial.HasEnded());
  EXPECT_TRUE(trial.HasReachedLimit());
  EXPECT_EQ(trial.TakeResult().ended_by, FailureReason::kNone);
}

TEST_F(PickingTrialTest, EstimatorOnDemandGivesTheSameTrial) {
  spec_.estimator.name = "gone";
  EXPECT_THAT(ErrorOf([&] { Setup(); }), HasSubstr("unknown estimator 'gone'"));
  TrialOptions options;
  options.estimator_on_demand = true;
  TrialSetup setup = Setup(options);
  PickingTrial trial(setup, BinIndex(0));
  EXPECT_THAT(ErrorOf([&] { trial.Attempt().ChooseGrasp(); }), HasSubstr("unknown estimator"));
  EXPECT_EQ(trial.Execute(std::nullopt).failure, FailureReason::kNoGrasp);
}

TEST_F(PickingTrialTest, SetSeedGivesTheBinsOfThatSeed) {
  spec_.cell.size_percent = 1;
  TrialSetup setup = Setup();
  const TrialResult first = RunTrial(setup, BinIndex(0));
  setup.SetSeed(12);
  const TrialResult other = RunTrial(setup, BinIndex(0));
  EXPECT_NE(HashesOf(first), HashesOf(other));
  spec_.seed = 12;
  TrialSetup of_seed = Setup();
  EXPECT_EQ(HashesOf(other), HashesOf(RunTrial(of_seed, BinIndex(0))));
  setup.SetSeed(11);
  EXPECT_EQ(HashesOf(first), HashesOf(RunTrial(setup, BinIndex(0))));
}

TEST_F(PickingTrialTest, WrittenTrialsAreAResultsFolder) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "run";
  EXPECT_THAT(ErrorOf([&] { WriteRun(spec_, EasyCube(), {}, false, out); }),
              HasSubstr("no finished trial"));
  TrialSetup setup = Setup();
  const std::vector<TrialResult> trials{RunTrial(setup, BinIndex(0)), RunTrial(setup, BinIndex(1))};
  WriteRun(spec_, EasyCube(), trials, false, out);
  EXPECT_EQ(ReadFileBytes(out / kTrialsFile), TrialsCsv(trials));
  EXPECT_EQ(ReadFileBytes(out / kAttemptsFile), AttemptsCsv(trials, {"cube"}));
  EXPECT_EQ(ResultsStore::OpenToRead(out).head().identity, RunIdentity(spec_, EasyCube()));
  EXPECT_THAT(ErrorOf([&] { WriteRun(spec_, EasyCube(), trials, false, out); }),
              HasSubstr("already has finished trials"));
  EXPECT_THAT(ErrorOf([&] { WriteRun(spec_, EasyCube(), trials, true, out); }),
              HasSubstr("other settings"));
}

}  // namespace
}  // namespace pickbed::tests
