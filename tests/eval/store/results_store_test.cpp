#include "eval/store/results_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "eval/summary/early_stop.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/full_trial.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ResultsStoreTest : public testing::Test {
 protected:
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

std::string ErrorOf(const std::function<void()>& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TEST_F(ResultsStoreTest, TrialReadBackIsBitIdentical) {
  ResultsStore(folder_, "seed: 1").Write(FullTrial(4));
  const auto read = ResultsStore(folder_, "seed: 1").ReadAll();
  ASSERT_EQ(read.size(), 1u);
  ExpectSameTrial(read[0], FullTrial(4));
}

TEST_F(ResultsStoreTest, ReturnsTheStoredSettings) {
  EXPECT_FALSE(StoredSettings(folder_).has_value());
  EXPECT_TRUE(std::filesystem::is_empty(folder_)) << "a query creates no file";
  ResultsStore(folder_, "seed: 1").Write(FullTrial(4));
  EXPECT_EQ(StoredSettings(folder_), "seed: 1");
}

TEST_F(ResultsStoreTest, OrderOfWritingDoesNotMatter) {
  ResultsStore store(folder_, "s");
  for (int trial : {5, 0, 3}) store.Write(FullTrial(trial));
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(0, 3, 5));
  const auto read = store.ReadAll();
  ASSERT_EQ(read.size(), 3u);
  const int expected[] = {0, 3, 5};
  for (int i = 0; i < 3; ++i) ExpectSameTrial(read[i], FullTrial(expected[i]));
}

TEST_F(ResultsStoreTest, RefusesResultsOfOtherSettings) {
  ResultsStore(folder_, "seed: 1").Write(FullTrial(0));
  const std::string error = ErrorOf([&] { ResultsStore(folder_, "seed: 2"); });
  EXPECT_THAT(error, HasSubstr(folder_.string()));
  EXPECT_THAT(error, HasSubstr("choose another results folder"));
}

TEST_F(ResultsStoreTest, KeepsConfigurationsWithTheirSeeds) {
  StoreHead head;
  head.configurations.push_back({0, "seed=1", 0, 2, 1, "seed: 1", "seed: 1"});
  head.configurations.push_back({1, "seed=2", 2, 2, 18446744073709551615u, "seed: 2", "seed: 2"});
  head.identity = SweepIdentity(head.configurations);
  {
    ResultsStore store(folder_, head);
    TrialResult result = FullTrial(2);
    result.configuration = 1;
    store.Write(result);
    store.WriteCrashed({3, 1, BinIndex{1}, 0, "signal 9"});
  }
  const ResultsStore store = ResultsStore::OpenToRead(folder_);
  ASSERT_EQ(store.head().configurations.size(), 2u);
  EXPECT_EQ(store.head().identity, head.identity);
  const StoredConfiguration& second = store.head().configurations[1];
  EXPECT_EQ(std::tie(second.number, second.name, second.first_trial, second.trials, second.seed,
                     second.identity, second.settings),
            std::make_tuple(1, "seed=2", 2, 2, 18446744073709551615u, "seed: 2", "seed: 2"));
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(2, 3));
  ASSERT_EQ(store.ReadAll().size(), 1u) << "a crashed trial has no result";
  EXPECT_EQ(store.ReadAll()[0].configuration, 1);
  const std::vector<CrashedTrial> crashed = store.Crashed();
  ASSERT_EQ(crashed.size(), 1u);
  EXPECT_EQ(crashed[0].trial, 3);
  EXPECT_EQ(crashed[0].configuration, 1);
  EXPECT_EQ(crashed[0].bin_index, 1);
  EXPECT_EQ(crashed[0].seed, 18446744073709551615u) << "the seed of the configuration";
  EXPECT_EQ(crashed[0].why, "signal 9");
}

// A progress line of a continued run has the same success rate as its summary.
TEST_F(ResultsStoreTest, StoredOutcomesAreThoseOfTheAttempts) {
  TrialResult result;
  for (const FailureReason failure :
       {FailureReason::kNone, FailureReason::kSlipped, FailureReason::kNoGrasp,
        FailureReason::kStirred, FailureReason::kPhysicsFailed}) {
    AttemptRecord& attempt = result.attempts.emplace_back();
    attempt.attempt = static_cast<int>(result.attempts.size()) - 1;
    attempt.failure = failure;
    if (failure == FailureReason::kNone || failure == FailureReason::kSlipped) {
      attempt.grasp = Grasp();
    }
  }
  ResultsStore store(folder_, "s");
  store.Write(result);
  const Cluster stored = store.Outcomes().at(0), counted = AttemptOutcomes(result);
  EXPECT_EQ(counted.samples, 4) << "two grasps, a stir, and a stir whose physics failed";
  EXPECT_EQ(stored.samples, counted.samples);
  EXPECT_EQ(stored.hits, counted.hits);
}

TEST_F(ResultsStoreTest, OutcomeOfATrialIsKnownOnceItIsFinished) {
  ResultsStore store(folder_, "s");
  store.Write(FullTrial(3));
  store.WriteCrashed({7, 0, BinIndex(7), 0, "signal 9"});
  const std::optional<Cluster> outcome = store.OutcomeOf(3);
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->samples, store.Outcomes().at(3).samples);
  EXPECT_EQ(outcome->hits, store.Outcomes().at(3).hits);
  EXPECT_FALSE(store.OutcomeOf(7)) << "it crashed";
  EXPECT_FALSE(store.OutcomeOf(4)) << "it is not in the store";
}

TEST_F(ResultsStoreTest, CrashedTrialsCanBeRemoved) {
  ResultsStore store(folder_, "s");
  store.Write(FullTrial(0));
  store.WriteCrashed({1, 0, BinIndex{1}, 0, "why"});
  store.ForgetCrashed();
  EXPECT_THAT(store.FinishedTrials(), ElementsAre(0));
}

TEST_F(ResultsStoreTest, ForEachAgreesWithReadAll) {
  ResultsStore store(folder_, "s");
  constexpr int kTrials = 300;  // more than are held in memory at once
  for (int trial = 0; trial < kTrials; ++trial) {
    TrialResult small;
    small.trial = 3 * trial;
    small.instances_dropped = trial;
    store.Write(small);
  }
  int next = 0;
  store.ForEach([&](const TrialResult& result) {
    EXPECT_EQ(result.trial, 3 * next);
    EXPECT_EQ(result.instances_dropped, next++);
  });
  EXPECT_EQ(next, kTrials);
}

TEST_F(ResultsStoreTest, StoreWithoutTrialsAcceptsNewSettings) {
  ResultsStore(folder_, "seed: 1");
  ResultsStore(folder_, "seed: 2").Write(FullTrial(0));
  EXPECT_EQ(ResultsStore(folder_, "seed: 2").ReadAll().size(), 1u);
  EXPECT_NE(ErrorOf([&] { ResultsStore(folder_, "seed: 1"); }), "");
}

TEST_F(ResultsStoreTest, SecondWriteOfATrialFailsAndKeepsTheFirst) {
  ResultsStore store(folder_, "s");
  store.Write(FullTrial(0));
  TrialResult other = FullTrial(0);
  other.instances_dropped = 99;
  EXPECT_THROW(store.Write(other), std::runtime_error);
  const auto read = store.ReadAll();
  ASSERT_EQ(read.size(), 1u);
  ExpectSameTrial(read[0], FullTrial(0));
}

TEST_F(ResultsStoreTest, RefusesAnUnusableFolderAndAnotherFile) {
  const auto file = folder_ / "file";
  std::ofstream(file) << "no folder";
  EXPECT_THAT(ErrorOf([&] { ResultsStore(file, "s"); }), HasSubstr("choose another"));
  std::ofstream(folder_ / "results.sqlite") << std::string(4096, 'x');
  EXPECT_THAT(ErrorOf([&] { ResultsStore(folder_, "s"); }), HasSubstr("results.sqlite"));
}

// Starts processes, releases them together and lets them write to one new file. Returns the number
// of processes that failed.
int FailuresOfWriters(const std::filesystem::path& folder, int processes, int trials_each) {
  int gate[2];
  EXPECT_EQ(pipe(gate), 0);
  std::vector<pid_t> children;
  for (int process = 0; process < processes; ++process) {
    const pid_t child = fork();
    if (child == 0) {
      close(gate[1]);
      char nothing;
      if (read(gate[0], &nothing, 1) != 0) _exit(2);  // returns when the parent closes its end
      try {
        ResultsStore store(folder, "s");
        for (int i = 0; i < trials_each; ++i) store.Write(FullTrial(process + i * processes));
      } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        _exit(1);
      }
      _exit(0);
    }
    children.push_back(child);
  }
  close(gate[0]);
  close(gate[1]);
  int failures = 0;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    failures += status != 0;
  }
  return failures;
}

TEST_F(ResultsStoreTest, SeveralProcessesWriteToOneFile) {
  constexpr int kProcesses = 8, kTrialsEach = 5;
  EXPECT_EQ(FailuresOfWriters(folder_, kProcesses, kTrialsEach), 0);
  const auto read = ResultsStore(folder_, "s").ReadAll();
  ASSERT_EQ(read.size(), static_cast<size_t>(kProcesses * kTrialsEach));
  for (size_t i = 0; i < read.size(); ++i) ExpectSameTrial(read[i], FullTrial(i));
}

TEST_F(ResultsStoreTest, SeveralProcessesCanOpenANewFileTogether) {
  constexpr int kTimes = 20, kProcesses = 8;  // in WAL mode, one of eight repetitions failed
  for (int i = 0; i < kTimes; ++i) {
    ASSERT_EQ(FailuresOfWriters(folder_ / std::to_string(i), kProcesses, 1), 0);
  }
}

TEST_F(ResultsStoreTest, KilledWriterLosesOnlyTheUnfinishedTrial) {
  const pid_t child = fork();
  if (child == 0) {
    ResultsStore store(folder_, "s");
    store.Write(FullTrial(0));
    store.Write(FullTrial(1));
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  EXPECT_THAT(ResultsStore(folder_, "s").FinishedTrials(), ElementsAre(0, 1));
}

TEST_F(ResultsStoreTest, JournalIsKeptBetweenTrialsAndRemovedWithItsWriter) {
  const auto journal = folder_ / "results.sqlite-journal";
  {
    ResultsStore store(folder_, "s");
    store.Write(FullTrial(0));
    EXPECT_TRUE(std::filesystem::exists(journal)) << "the journal is created again for each trial";
    EXPECT_THAT(ResultsStore::OpenToRead(folder_).FinishedTrials(), ElementsAre(0));
    ResultsStore(folder_, "s").Write(FullTrial(1));
    EXPECT_FALSE(std::filesystem::exists(journal));
    store.Write(FullTrial(2));  // the other writer has removed the journal
  }
  EXPECT_FALSE(std::filesystem::exists(journal));
  EXPECT_THAT(ResultsStore::OpenToRead(folder_).FinishedTrials(), ElementsAre(0, 1, 2));
}

TEST_F(ResultsStoreTest, JournalOfAKilledWriterIsNotNeeded) {
  const pid_t child = fork();
  if (child == 0) {
    ResultsStore store(folder_, "s");
    store.Write(FullTrial(0));
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  const auto journal = folder_ / "results.sqlite-journal";
  ASSERT_TRUE(std::filesystem::exists(journal));
  const auto copy = folder_ / "copy";
  std::filesystem::create_directory(copy);
  std::filesystem::copy_file(folder_ / "results.sqlite", copy / "results.sqlite");
  EXPECT_THAT(ResultsStore::OpenToRead(copy).FinishedTrials(), ElementsAre(0));
  ResultsStore::Tidy(folder_);
  EXPECT_FALSE(std::filesystem::exists(journal));
  EXPECT_THAT(ResultsStore::OpenToRead(folder_).FinishedTrials(), ElementsAre(0));
}

}  // namespace
}  // namespace pickbed::tests
