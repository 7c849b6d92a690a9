#include "eval/sweep/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "eval/sweep/merge_shards.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class SweepTest : public testing::Test {
 protected:
  SweepOptions Options(const std::string& name, int jobs = 1) const {
    SweepOptions options;
    options.out = folder_ / name;
    options.jobs = jobs;
    options.make = StubTrials();
    return options;
  }
  std::string Read(const std::string& name) const { return ReadFileBytes(folder_ / name); }
  // Number of calls of Mark() in all workers; each call appends one character.
  int Count(const std::string& name) const {
    return std::filesystem::exists(folder_ / name) ? static_cast<int>(Read(name).size()) : 0;
  }
  void Mark(const std::string& name) const {
    std::ofstream(folder_ / name, std::ios::app).put('x').flush();
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

constexpr const char* kFilesWithoutTimes[] = {"summary.json",       "trials.csv",
                                              "attempts.csv",       "instance_outcomes.csv",
                                              "configurations.csv", "sweep.yaml"};

TEST_F(SweepTest, ResultsDoNotDependOnJobsOrShards) {
  const Sweep sweep = StubSweep(3, 7);
  const auto crash_once = [](const Configuration& point, int scene) {
    if (point.number == 1 && scene == 3) raise(SIGKILL);
  };
  for (const auto& [name, jobs] :
       {std::pair("one", 1), std::pair("two", 2), std::pair("many", 9)}) {
    SweepOptions options = Options(name, jobs);
    options.make = StubTrials(crash_once);
    const SweepReport report = RunSweep(sweep, options, {});
    EXPECT_THAT(report.crashed, SizeIs(1));
    EXPECT_EQ(report.finished, 21);
  }
  std::vector<std::filesystem::path> shards;
  for (int i = 4; i >= 1; --i) {
    SweepOptions options = Options("sharded", i);
    options.make = StubTrials(crash_once);
    options.shard = {i, 4};
    RunSweep(sweep, options, {});
    shards.push_back(ShardFolder(options.out, options.shard));
  }
  const MergeReport merged = MergeStores(shards, folder_ / "sharded");
  EXPECT_EQ(merged.trials, 21);
  EXPECT_EQ(merged.missing, 0);
  for (const char* file : kFilesWithoutTimes) {
    const std::string one = Read(std::string("one/") + file);
    EXPECT_FALSE(one.empty()) << file;
    EXPECT_EQ(Read(std::string("two/") + file), one) << file;
    EXPECT_EQ(Read(std::string("many/") + file), one) << file;
    EXPECT_EQ(Read(std::string("sharded/") + file), one) << file;
  }
}

TEST_F(SweepTest, ShardOfAnotherSweepIsRefusedAndChangesNothing) {
  SweepOptions options = Options("shared");
  Sweep sweep = StubSweep(1, 4);
  sweep.yaml = "scenario: stub\ngrid: {seed: [5]}\nslurm:\n  shards: 2\n";
  options.shard = {1, 2};
  RunSweep(sweep, options, {});
  const std::string yaml = Read("shared/sweep.yaml");
  Sweep other = StubSweep(1, 4);
  other.yaml = "scenario: stub\ngrid: {seed: [6]}\n";
  options.shard = {2, 2};
  EXPECT_THAT(ErrorOf([&] { RunSweep(other, options, {}); }),
              HasSubstr("sweep.yaml belongs to a sweep with other settings"));
  EXPECT_EQ(Read("shared/sweep.yaml"), yaml);
  EXPECT_FALSE(std::filesystem::exists(ShardFolder(options.out, options.shard) / "results.sqlite"));
  sweep.yaml = "scenario: stub\ngrid: {seed: [5]}\nslurm:\n  shards: 8\n";
  EXPECT_EQ(RunSweep(sweep, options, {}).finished, 2) << "the slurm section may differ";
}

TEST_F(SweepTest, LeavesNoJournalBesideTheStore) {
  RunSweep(StubSweep(1, 8), Options("whole", 3), {});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "whole/results.sqlite-journal"));
  SweepOptions shard = Options("sharded", 3);
  shard.shard = {2, 2};
  RunSweep(StubSweep(1, 8), shard, {});
  const auto folder = ShardFolder(shard.out, shard.shard);
  EXPECT_TRUE(std::filesystem::exists(folder / "results.sqlite"));
  EXPECT_FALSE(std::filesystem::exists(folder / "results.sqlite-journal"));
}

TEST_F(SweepTest, TrialsAreNumberedByConfigurationAndPairedByBin) {
  RunSweep(StubSweep(2, 3), Options("s", 2), {});
  const ResultsStore store = ResultsStore::OpenToRead(folder_ / "s");
  const auto trials = store.ReadAll();
  ASSERT_EQ(trials.size(), 6u);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(trials[i].trial, i);
    EXPECT_EQ(trials[i].configuration, i / 3);
    EXPECT_EQ(trials[i].bin_index, i % 3);
    const TrialResult expected = FullTrial(100 * (5 + i / 3) + i % 3);
    EXPECT_EQ(trials[i].certificate.simulated_s, expected.certificate.simulated_s);
  }
  EXPECT_EQ(store.head().configurations[1].seed, 6u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "s/configurations/01_seed=6.yaml"));
}

TEST_F(SweepTest, TrialThatCrashesOnceIsRepeated) {
  SweepOptions options = Options("s", 2);
  options.make = StubTrials([&](const Configuration& point, int scene) {
    if (point.number != 1 || scene != 2) return;
    Mark("tries");
    if (Count("tries") == 1) raise(SIGSEGV);
  });
  const SweepReport report = RunSweep(StubSweep(2, 4), options, {});
  EXPECT_THAT(report.crashed, IsEmpty());
  EXPECT_EQ(Count("tries"), 2);
  RunSweep(StubSweep(2, 4), Options("whole"), {});
  EXPECT_EQ(Read("s/attempts.csv"), Read("whole/attempts.csv"));
}

TEST_F(SweepTest, TrialThatCrashesTwiceIsRecordedAndCountsInNoRate) {
  SweepOptions options = Options("s", 2);
  options.make = StubTrials([&](const Configuration& point, int scene) {
    if (point.number != 1 || scene != 2) return;
    Mark("tries");
    signal(SIGSEGV, SIG_DFL);  // a sanitizer would end the process with a status
    raise(SIGSEGV);
  });
  const SweepReport report = RunSweep(StubSweep(2, 4), options, {});
  EXPECT_EQ(Count("tries"), 2);
  ASSERT_THAT(report.crashed, SizeIs(1));
  const auto stored = ResultsStore::OpenToRead(options.out).Crashed();
  ASSERT_THAT(stored, SizeIs(1));
  EXPECT_EQ(stored[0].trial, 6);
  EXPECT_EQ(stored[0].configuration, 1);
  EXPECT_EQ(stored[0].bin_index, 2);
  EXPECT_EQ(stored[0].seed, 6u);
  EXPECT_THAT(stored[0].why, HasSubstr("signal 11"));
  ASSERT_THAT(report.configurations, SizeIs(2));
  EXPECT_EQ(report.configurations[1].summary.trials, 3);
  EXPECT_THAT(report.configurations[1].summary.crashed, SizeIs(1));
  EXPECT_THAT(Read("s/trials.csv"), HasSubstr("\n6,1,2,crashed,"));

  // It is not repeated unless retry_crashed is set.
  options.make = StubTrials();
  options.resume = true;
  RunSweep(StubSweep(2, 4), options, {});
  EXPECT_THAT(ResultsStore::OpenToRead(options.out).Crashed(), SizeIs(1));
  options.retry_crashed = true;
  RunSweep(StubSweep(2, 4), options, {});
  EXPECT_THAT(ResultsStore::OpenToRead(options.out).Crashed(), IsEmpty());
  EXPECT_THAT(ResultsStore::OpenToRead(options.out).ReadAll(), SizeIs(8));
}

TEST_F(SweepTest, TrialThatIsStoredBeforeItsWorkerIsKilledCountsOnce) {
  const Sweep sweep = StubSweep(2, 4);
  RunSweep(sweep, Options("whole"), {});
  const std::vector<TrialResult> expected = ResultsStore::OpenToRead(folder_ / "whole").Read(6, 7);
  ASSERT_THAT(expected, SizeIs(1));
  Cluster total;
  for (const auto& [trial, outcome] : ResultsStore::OpenToRead(folder_ / "whole").Outcomes()) {
    total.samples += outcome.samples;
    total.hits += outcome.hits;
  }
  for (const int crashes_before : {0, 1}) {
    const std::string name = fmt::format("crashes_{}", crashes_before);
    SweepOptions options = Options(name, 2);
    options.make = StubTrials([&](const Configuration& point, int scene) {
      if (point.number != 1 || scene != 2) return;
      Mark(name + "_tries");
      if (Count(name + "_tries") > crashes_before) {
        ResultsStore(options.out, HeadOf(sweep, options.out)).Write(expected[0]);
      }
      raise(SIGKILL);
    });
    RunListener listener;
    Cluster reported;
    listener.on_trial = [&](const RunState& state) {
      reported = {};
      for (const Cluster& trial : state.trials) {
        reported.samples += trial.samples;
        reported.hits += trial.hits;
      }
    };
    const SweepReport report = RunSweep(sweep, options, listener);
    EXPECT_THAT(report.crashed, IsEmpty());
    EXPECT_EQ(report.finished, 8);
    EXPECT_EQ(Count(name + "_tries"), crashes_before + 1);
    EXPECT_EQ(reported.samples, total.samples);
    EXPECT_EQ(reported.hits, total.hits);
    for (const char* file : {"trials.csv", "attempts.csv"}) {
      EXPECT_EQ(Read(name + "/" + file), Read(std::string("whole/") + file));
    }
  }
}

TEST_F(SweepTest, WorkerPreparesEachConfigurationOnce) {
  for (const int jobs : {1, 2}) {
    const std::string mark = fmt::format("made_by_{}", jobs);
    SweepOptions options = Options(mark + "_out", jobs);
    options.make = [&](const Configuration& point, const WorkerPlan::Say& say) {
      Mark(mark);
      return StubTrials([](const Configuration&, int) { usleep(3000); })(point, say);
    };
    RunSweep(StubSweep(6, 10), options, {});
    EXPECT_GE(Count(mark), 6);
    EXPECT_LE(Count(mark), 6 + jobs - 1) << "two workers share at most the last configuration";
  }
}

TEST_F(SweepTest, FinishedTrialsRequireResume) {
  RunSweep(StubSweep(2, 2), Options("s"), {});
  EXPECT_THAT(ErrorOf([&] { RunSweep(StubSweep(2, 2), Options("s"), {}); }),
              HasSubstr("already has 4 finished trials"));
  SweepOptions options = Options("s");
  options.resume = true;
  EXPECT_THAT(ErrorOf([&] { RunSweep(StubSweep(2, 3), options, {}); }),
              HasSubstr("other settings"));
}

// The running success rate covers all finished trials, also from earlier calls.
TEST_F(SweepTest, ResumedProgressIncludesStoredTrials) {
  const Sweep sweep = StubSweep(2, 5);
  SweepOptions options = Options("s");
  options.only_trials = {0, 1, 2, 6};
  options.make = StubTrials([](const Configuration& point, int scene) {
    if (point.number == 0 && scene == 2) raise(SIGKILL);
  });
  RunSweep(sweep, options, {});
  options = Options("s", 2);
  options.resume = true;
  std::vector<RunState> states;
  RunListener listener;
  listener.on_trial = [&](const RunState& state) { states.push_back(state); };
  const SweepReport report = RunSweep(sweep, options, listener);
  ASSERT_EQ(states.size(), 6u);
  EXPECT_EQ(states.front().done, 5);
  EXPECT_EQ(states.front().done_before, 4);
  EXPECT_EQ(states.front().crashed, 1);
  EXPECT_EQ(states.front().trials.size(), 4u);
  Cluster reported = SumOf(states.back().trials), stored;
  for (const ConfigurationSummary& point : report.configurations) {
    stored.hits += point.summary.successes;
    stored.samples += point.summary.executed_grasps;
  }
  EXPECT_GT(stored.samples, 0);
  EXPECT_EQ(reported.samples, stored.samples);
  EXPECT_EQ(reported.hits, stored.hits);
}

TEST_F(SweepTest, SecondSweepInTheFolderIsRefusedWhileTheFirstRuns) {
  const pid_t first = fork();
  if (first == 0) {
    SweepOptions options = Options("s", 2);
    options.make = StubTrials([&](const Configuration&, int) {
      Mark("started");
      pause();
    });
    RunSweep(StubSweep(1, 4), options, {});
    _exit(0);
  }
  while (Count("started") == 0) usleep(10000);
  EXPECT_THAT(ErrorOf([&] { RunSweep(StubSweep(1, 4), Options("s"), {}); }),
              HasSubstr(fmt::format("in use by process {}", first)));
  kill(first, SIGKILL);
  waitpid(first, nullptr, 0);
  EXPECT_EQ(RunSweep(StubSweep(1, 4), Options("s"), {}).finished, 4);
}

TEST_F(SweepTest, KilledSweepResumesWithoutMissingOrDuplicateTrials) {
  const Sweep sweep = StubSweep(3, 30);
  Rng rng(1);
  SweepOptions options = Options("s", 2);
  options.resume = true;
  options.make = StubTrials([&](const Configuration&, int) { usleep(2000); });
  size_t before = 0;
  for (int kills = 0; kills < 6; ++kills) {
    const pid_t child = fork();
    if (child == 0) {
      RunSweep(sweep, options, {});
      _exit(0);
    }
    usleep(static_cast<useconds_t>(rng.Uniform(20e3, 250e3)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    usleep(100000);  // the workers end a moment later
    if (!StoredSettings(options.out)) continue;
    const size_t now = ResultsStore::OpenToRead(options.out).FinishedTrials().size();
    EXPECT_GE(now, before) << "a finished trial was lost";
    before = now;
  }
  RunSweep(sweep, options, {});
  RunSweep(sweep, Options("whole"), {});
  EXPECT_EQ(Read("s/trials.csv"), Read("whole/trials.csv"));
  EXPECT_EQ(Read("s/attempts.csv"), Read("whole/attempts.csv"));
}

TEST(Shards, AreDisjointBalancedAndKeepBinsTogether) {
  const Sweep sweep = StubSweep(3, 10);
  for (const int count : {1, 2, 4, 8, 40}) {
    std::vector<int> all;
    size_t minimum = 100, maximum = 0;
    int split_scenes = 0;
    for (int i = 1; i <= count; ++i) {
      const std::vector<int> trials = TrialsOfShard(sweep, {i, count});
      minimum = std::min(minimum, trials.size());
      maximum = std::max(maximum, trials.size());
      std::map<int, int> points_of_scene;
      for (const int trial : trials) ++points_of_scene[trial % 10];
      for (const auto& [scene, points] : points_of_scene) split_scenes += points < 3;
      all.insert(all.end(), trials.begin(), trials.end());
    }
    std::sort(all.begin(), all.end());
    EXPECT_EQ(all.size(), 30u) << count << " shards";
    EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
    EXPECT_LE(maximum - minimum, 1u);
    if (count <= 8) {
      EXPECT_LE(split_scenes, 2 * (count - 1)) << "only at the borders";
    }
  }
}

TEST(Shards, AreParsedFromText) {
  EXPECT_EQ(ParseShard("3/8").index, 3);
  EXPECT_EQ(ParseShard("3/8").count, 8);
  for (const char* wrong : {"0/8", "9/8", "3", "3/8x", "a/b", "-1/2", "1/0"}) {
    EXPECT_THAT(ErrorOf([&] { ParseShard(wrong); }), HasSubstr("I/N")) << wrong;
  }
}

}  // namespace
}  // namespace pickbed::tests
