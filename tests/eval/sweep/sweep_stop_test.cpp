#include "eval/sweep/sweep_stop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "eval/sweep/slurm.h"
#include "eval/sweep/sweep.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kWidth = 0.6;

// Picks succeed in three of four bins of configuration 0, in every second bin of configuration 1,
// and in all bins of configuration 2.
Cluster OutcomeIn(int point, int scene) {
  if (scene % 7 == 5) return {0, 0};  // no grasp
  const bool picked = point == 0 ? scene % 4 != 1 : point == 2 || scene % 2 == 0;
  return {picked ? 2 : 0, 2};
}

// Some bins take longer, so that several workers finish them out of order.
MakeDoTrial UnevenTrials() {
  return [](const Configuration& point, const WorkerPlan::Say&) -> DoTrial {
    return [&point](int scene, const PictureOrder& pictures) {
      if (scene % 5 == 0) usleep(8000);
      std::filesystem::create_directories(pictures.folder);
      WriteFileAtomically(pictures.folder / "pick.png", "picture");
      TrialResult result;
      const Cluster outcome = OutcomeIn(point.number, scene);
      result.instances_cleared = outcome.hits;
      for (int i = 0; i < outcome.samples; ++i) {
        AttemptRecord& pick = result.attempts.emplace_back();
        pick.attempt = i;
        pick.grasp = Grasp();
        pick.hypotheses.emplace_back();
        pick.chosen = 0;
        pick.failure = i < outcome.hits ? FailureReason::kNone : FailureReason::kSlipped;
      }
      return result;
    };
  };
}

Sweep StoppingSweep(double width, int points = 3) {
  Sweep sweep = StubSweep(points, 60);
  for (Configuration& point : sweep.configurations) point.spec.stop_width = width;
  return sweep;
}

// Number of bins that a configuration needs when they arrive in order.
int ScenesNeeded(int point) {
  SequentialStop stop(kWidth);
  int scene = 0;
  while (!stop.Reached()) stop.Add(OutcomeIn(point, scene++));
  return scene;
}

class SweepStopTest : public testing::Test {
 protected:
  SweepOptions Options(const std::string& name, int jobs = 1) const {
    SweepOptions options;
    options.out = folder_ / name;
    options.jobs = jobs;
    options.make = UnevenTrials();
    options.picture_trials = 60;
    return options;
  }
  std::string Read(const std::string& name) const { return ReadFileBytes(folder_ / name); }
  std::vector<int> Stored(const std::string& name) const {
    return ResultsStore::OpenToRead(folder_ / name).FinishedTrials();
  }
  void ExpectSameFiles(const std::string& a, const std::string& b) const {
    for (const char* file : {"summary.json", "trials.csv", "attempts.csv", "configurations.csv"}) {
      EXPECT_EQ(Read(a + "/" + file), Read(b + "/" + file)) << file;
    }
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(SweepStopTest, StopDoesNotDependOnTheNumberOfWorkers) {
  const Sweep sweep = StoppingSweep(kWidth);
  std::vector<int> expected;
  for (int point = 0; point < 3; ++point) {
    const int scenes = ScenesNeeded(point);
    ASSERT_GT(scenes, 3);
    ASSERT_LT(scenes, 60);
    for (int scene = 0; scene < scenes; ++scene) expected.push_back(60 * point + scene);
  }
  for (const auto& [name, jobs] :
       {std::pair("one", 1), std::pair("two", 2), std::pair("many", 7)}) {
    int last_total = 0;
    RunListener listener;
    listener.on_trial = [&](const RunState& state) { last_total = state.total; };
    const SweepReport report = RunSweep(sweep, Options(name, jobs), listener);
    EXPECT_EQ(Stored(name), expected) << jobs << " workers";
    EXPECT_EQ(report.finished, static_cast<int>(expected.size()));
    EXPECT_EQ(report.total, report.finished);
    EXPECT_EQ(last_total, report.total);
    int pictured = 0;
    for (int trial = 0; trial < 180; ++trial) {
      pictured +=
          std::filesystem::exists(folder_ / name / fmt::format("pictures/trial_{:04}", trial));
    }
    EXPECT_EQ(pictured, report.finished) << "pictures of trials that do not count";
  }
  ExpectSameFiles("one", "two");
  ExpectSameFiles("one", "many");
}

TEST_F(SweepStopTest, SummaryReportsTheStopAndItsInterval) {
  const SweepReport report = RunSweep(StoppingSweep(kWidth), Options("s", 2), {});
  for (int point = 0; point < 3; ++point) {
    const std::optional<StopState>& stop = report.configurations[point].summary.stop;
    ASSERT_TRUE(stop.has_value());
    EXPECT_TRUE(stop->reached);
    EXPECT_EQ(stop->bins, ScenesNeeded(point));
    EXPECT_LE(stop->interval.high - stop->interval.low, kWidth);
  }
  EXPECT_THAT(SweepTable(report.configurations),
              HasSubstr(fmt::format("seed=5: stops after {} bins", ScenesNeeded(0))));
  EXPECT_THAT(Read("s/summary.json"), HasSubstr("\"reached\": true"));
  const SweepReport never = RunSweep(StubSweep(2, 3), Options("never"), {});
  EXPECT_THAT(Read("never/summary.json"), Not(HasSubstr("\"stop\"")));
}

TEST_F(SweepStopTest, KilledAndResumedSweepStopsAtTheSameBin) {
  const Sweep sweep = StoppingSweep(kWidth);
  SweepOptions options = Options("s", 3);
  options.resume = true;
  Rng rng(4);
  for (int kills = 0; kills < 4; ++kills) {
    const pid_t child = fork();
    if (child == 0) {
      RunSweep(sweep, options, {});
      _exit(0);
    }
    usleep(static_cast<useconds_t>(rng.Uniform(20e3, 120e3)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    usleep(100000);  // the workers end a moment later
  }
  RunSweep(sweep, options, {});
  RunSweep(sweep, Options("whole"), {});
  ExpectSameFiles("s", "whole");
}

TEST_F(SweepStopTest, NarrowerWidthContinuesAndWiderWidthIsRefused) {
  RunSweep(StoppingSweep(kWidth), Options("s"), {});
  SweepOptions options = Options("s");
  options.resume = true;
  EXPECT_THAT(ErrorOf([&] { RunSweep(StoppingSweep(0.9), options, {}); }),
              HasSubstr("finished trials beyond the bin at which its configurations stop"));
  RunSweep(StoppingSweep(0.5), options, {});
  RunSweep(StoppingSweep(0.5), Options("at_once"), {});
  EXPECT_GT(Stored("s").size(), static_cast<size_t>(3 * ScenesNeeded(2)));
  ExpectSameFiles("s", "at_once");
  RunSweep(StoppingSweep(0), options, {});
  EXPECT_EQ(Stored("s").size(), 180u);
}

TEST_F(SweepStopTest, EarlierCrashBeyondTheStopIsNotCounted) {
  const Sweep sweep = StoppingSweep(kWidth);
  SweepOptions options = Options("s");
  RunSweep(sweep, options, {});
  {
    ResultsStore store(options.out, HeadOf(sweep, options.out));
    store.WriteCrashed({59, 0, BinIndex(59), 0, "killed"});
    store.Forget({121});
  }
  options.resume = true;
  int crashed = -1;
  RunListener listener;
  listener.on_trial = [&](const RunState& state) { crashed = state.crashed; };
  RunSweep(sweep, options, listener);
  EXPECT_EQ(crashed, 0);
}

// A worker may be killed after it stored a trial and before its reply. If the configuration ends
// before the trial is tried again, the trial is only in the store.
TEST_F(SweepStopTest, TrialThatIsOnlyInTheStoreIsForgottenBeyondTheStop) {
  const Sweep sweep = StoppingSweep(kWidth);
  RunSweep(sweep, Options("whole"), {});
  const std::vector<TrialResult> first = ResultsStore::OpenToRead(folder_ / "whole").Read(0, 1);
  ASSERT_EQ(first.size(), 1u);
  SweepOptions options = Options("s");
  const MakeDoTrial make = options.make;
  options.make = [&](const Configuration& point, const WorkerPlan::Say& say) -> DoTrial {
    const DoTrial do_trial = make(point, say);
    return [&, do_trial](BinIndex bin_index, const PictureOrder& pictures) {
      if (point.number == 0 && bin_index == 0) {
        TrialResult last = first[0];
        last.trial = 59;
        last.bin_index = BinIndex(59);
        ResultsStore(options.out, HeadOf(sweep, options.out)).Write(last);
      }
      return do_trial(bin_index, pictures);
    };
  };
  RunSweep(sweep, options, {});
  EXPECT_EQ(Stored("s"), Stored("whole"));
}

// The shard has bins 30 to 59 and therefore not the first bin.
TEST_F(SweepStopTest, ShardsAndSlurmAreRefused) {
  SweepOptions options = Options("s");
  options.shard = {2, 2};
  EXPECT_THAT(ErrorOf([&] { RunSweep(StoppingSweep(kWidth), options, {}); }),
              HasSubstr("stop_width = 0.6: a shard does not have the scenes of the other shards"));
  SlurmJob job;
  job.out = folder_ / "slurm";
  EXPECT_THAT(ErrorOf([&] { RunOnSlurm(StoppingSweep(kWidth), job, {}); }),
              HasSubstr("stop_width = 0.6: a shard does not have the scenes of the other shards"));
}

TEST(ConfigurationStop, WaitsForAllEarlierBins) {
  ConfigurationStop stop(kWidth);
  for (int scene = 59; scene > 0; --scene) stop.Add(BinIndex(scene), OutcomeIn(2, scene));
  EXPECT_EQ(stop.state().bins, 0);
  EXPECT_TRUE(stop.Counts(BinIndex(59)));
  stop.Add(BinIndex{0}, OutcomeIn(2, 0));
  EXPECT_EQ(stop.state().bins, ScenesNeeded(2));
  EXPECT_TRUE(stop.Counts(BinIndex(ScenesNeeded(2) - 1)));
  EXPECT_FALSE(stop.Counts(BinIndex(ScenesNeeded(2))));
}

}  // namespace
}  // namespace pickbed::tests
