#include "eval/sweep/recorded_picks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr char kPickScenario[] =
    "seed: 3\ntrials: 2\n"
    "objects:\n  - {name: cube, count: 2, mesh: cube.obj, mass_kg: 0.05}\n"
    "estimator: {name: oracle}\n";

// A trial of two picks at matched poses. The first one succeeded.
TrialResult TwoPicks(int trial) {
  TrialResult result;
  result.trial = trial;
  result.instances_dropped = 2;
  result.instances_cleared = 1;
  for (int i = 0; i < 2; ++i) {
    AttemptRecord& attempt = result.attempts.emplace_back();
    attempt.attempt = i;
    attempt.chosen = 0;
    attempt.matched_instance = InstanceId(i);
    HypothesisRecord& pose = attempt.hypotheses.emplace_back();
    pose.object = ObjectId{0};
    pose.instance = InstanceId(i);
    pose.X_OE.translation().x() = 0.001 * (i + 1);
    attempt.grasp = Grasp();
    attempt.failure = i == 0 ? FailureReason::kNone : FailureReason::kSlipped;
    attempt.outcome.verdicts[static_cast<int>(SuccessRule::kRightInstance)] = i == 0;
  }
  return result;
}

// A results folder with two such trials.
class RecordedPicks : public testing::Test {
 protected:
  void SetUp() override {
    SaveObj(folder_.path() / "cube.obj", Cube(0.03, 0.05, 0.5)->mesh_O);
    folder_.Write(kScenarioFile, kPickScenario);
    const LoadedScenario scenario =
        FindScenario({(folder_.path() / kScenarioFile).string(), {}, "no_catalog", {}});
    StoredConfiguration configuration;
    configuration.trials = 2;
    configuration.settings = kPickScenario;
    configuration.identity = RunIdentity(scenario.spec, scenario.objects);
    ResultsStore store(folder_.path(), StoreHead{configuration.identity, {configuration}});
    for (int trial = 0; trial < 2; ++trial) store.Write(TwoPicks(trial));
  }
  std::vector<JudgedPick> Picks() const {
    return PicksOfRun(folder_.path(), "no_catalog", "cube", "jaw_8cm");
  }

  const TemporaryFolder folder_;
};

TEST_F(RecordedPicks, HaveTheErrorsAndVerdictsOfTheRun) {
  const std::vector<JudgedPick> picks = Picks();
  ASSERT_EQ(picks.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(picks[i].X_OE.translation().x(), 0.001 * (i % 2 + 1));
    EXPECT_EQ(picks[i].success, i % 2 == 0);
    EXPECT_EQ(picks[i].cluster, i / 2);
  }
  EXPECT_THAT(ErrorOf([&] { PicksOfRun(folder_.path(), "no_catalog", "ball", "jaw_8cm"); }),
              HasSubstr("matches an instance of ball"));
}

TEST_F(RecordedPicks, AreRefusedWithTheTableOfADamagedTrial) {
  struct {
    std::string edit, undo, message;
  } const cases[] = {
      {"UPDATE trials SET instances_cleared = 2 WHERE trial = 1",
       "UPDATE trials SET instances_cleared = 1",
       "table 'trials', trial 1: 1 attempts succeeded, but column 'instances_cleared' is 2; "},
      {"UPDATE attempts SET band = 9 WHERE trial = 1 AND attempt = 0",
       "UPDATE attempts SET band = -1", "table 'attempts', trial 1: the settings have no band 9; "},
      {"UPDATE hypotheses SET object = 1 WHERE trial = 1", "UPDATE hypotheses SET object = 0",
       "table 'hypotheses', trial 1: the settings have no object 1; "},
      {"UPDATE attempts SET executed = 0 WHERE trial = 1 AND failure = 'none'",
       "UPDATE attempts SET executed = 1",
       "table 'attempts', trial 1: attempt 0 has neither a grasp nor a failure; "},
  };
  const std::filesystem::path file = folder_.path() / kStoreFile;
  for (const auto& test : cases) {
    Database(file, Database::Mode::kExisting).Execute(test.edit);
    const std::string error = ErrorOf([&] { Picks(); });
    EXPECT_THAT(error, testing::StartsWith(file.string() + ": " + test.message));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    Database(file, Database::Mode::kExisting).Execute(test.undo);
    EXPECT_EQ(Picks().size(), 4u);
  }
}

}  // namespace
}  // namespace pickbed::tests
