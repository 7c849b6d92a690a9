// Measurements of sweeps, run by hand. With a stub instead of physics:
//
//   sweep_figures store 10000   trials into 8 shards, merged: seconds and peak memory
//   sweep_figures kills 50      kill -9 of a sweep at random moments, resumed each time: lost and
//                               repeated trials, damaged stores
//
// With a real sweep and 2 workers:
//
//   sweep_figures share SWEEP.yaml 8   trials per configuration: fraction of the time for store and
//                                      statistics

#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "eval/cli/run_progress.h"
#include "eval/runtime/progress.h"
#include "eval/store/results_store.h"
#include "eval/sweep/merge_shards.h"
#include "eval/sweep/sweep_spec.h"
#include "scenes/base/files.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double PeakMegabytes(int who) {
  rusage usage;
  getrusage(who, &usage);
  return usage.ru_maxrss / 1024.0;
}

void MeasureStore(int trials) {
  constexpr int kShards = 8, kConfigurations = 4;
  const TemporaryFolder temporary;
  const Sweep sweep = StubSweep(kConfigurations, trials / kConfigurations);
  SweepOptions options;
  options.out = temporary.path() / "sweep";
  options.jobs = 2;
  options.make = StubTrials();
  std::vector<std::filesystem::path> shards;
  const auto start = Clock::now();
  for (int i = 1; i <= kShards; ++i) {
    options.shard = {i, kShards};
    RunSweep(sweep, options, {});
    shards.push_back(ShardFolder(options.out, options.shard));
  }
  const double stored_s = SecondsSince(start);
  const auto merge_start = Clock::now();
  const MergeReport report = MergeStores(shards, options.out);
  fmt::print("{} trials into {} shards: {:.1f} s; merged with their files: {:.1f} s\n",
             report.trials, kShards, stored_s, SecondsSince(merge_start));
  fmt::print("results.sqlite {:.0f} MB, peak memory {:.0f} MB (workers {:.0f} MB)\n",
             std::filesystem::file_size(options.out / "results.sqlite") / 1e6,
             PeakMegabytes(RUSAGE_SELF), PeakMegabytes(RUSAGE_CHILDREN));
}

// Returns the finished trials of a store. Throws if the store is damaged.
std::vector<int> Finished(const std::filesystem::path& folder) {
  if (!StoredSettings(folder)) return {};  // killed before the tables were created
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  if (store.ReadAll().size() != store.FinishedTrials().size()) {
    throw std::runtime_error("some trials cannot be read");
  }
  return store.FinishedTrials();
}

void MeasureKills(int kills) {
  const TemporaryFolder temporary;
  const Sweep sweep = StubSweep(4, 500);
  SweepOptions options;
  options.out = temporary.path() / "killed";
  options.jobs = 2;
  options.resume = true;
  options.make = StubTrials([](const Configuration&, int) { usleep(5000); });
  Rng rng(1);
  int lost = 0, early = 0;
  std::vector<int> before;
  for (int k = 0; k < kills; ++k) {
    const pid_t child = fork();
    if (child == 0) {
      RunSweep(sweep, options, {});
      _exit(0);
    }
    usleep(static_cast<useconds_t>(rng.Uniform(5e3, 600e3)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    usleep(100000);
    const std::vector<int> now = Finished(options.out);
    for (const int trial : before) lost += !std::binary_search(now.begin(), now.end(), trial);
    early += now.empty();
    before = now;
  }
  fmt::print("{} kills, {} before the first trial; {} of 2000 trials done, {} lost\n", kills, early,
             before.size(), lost);
  RunSweep(sweep, options, {});
  SweepOptions whole = options;
  whole.out = temporary.path() / "whole";
  RunSweep(sweep, whole, {});
  for (const char* file : {"trials.csv", "attempts.csv", "instance_outcomes.csv"}) {
    const bool same = ReadFileBytes(options.out / file) == ReadFileBytes(whole.out / file);
    fmt::print("{}: {} as without kills\n", file, same ? "the same" : "NOT the same");
  }
}

void MeasureShare(const std::filesystem::path& file, int trials) {
  const TemporaryFolder temporary;
  SweepOptions options;
  options.out = temporary.path() / "sweep";
  options.jobs = 2;
  SweepSpec spec = LoadSweepSpec(file);
  if (trials > 0) spec.trials = trials;
  const auto start = Clock::now();
  SweepReport report;
  {
    ProgressLine progress;
    report = RunSweep(MakeSweep(spec, options.out, "objects"), options,
                      ShowOn(progress, [] { return false; }));
  }
  const double wall_s = SecondsSince(start);
  double all_s = 0;
  for (const auto& [stage, seconds] : report.seconds) all_s += seconds;
  fmt::print("{} trials by {} workers in {:.1f} s\n", report.finished, options.jobs, wall_s);
  for (const auto& [stage, seconds] : report.seconds) {
    fmt::print("{:<10}{:10.3f} s {:8.3f} %\n", stage, seconds, 100 * seconds / all_s);
  }
  const double kept_s =
      report.seconds["store"] + report.seconds["progress"] + report.seconds["files"];
  fmt::print("store, progress and files with statistics: {:.3f} %\n", 100 * kept_s / all_s);
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "share" && argc > 2) {
    pickbed::tests::MeasureShare(argv[2], argc > 3 ? std::atoi(argv[3]) : 0);
    return 0;
  }
  const int number = argc > 2 ? std::atoi(argv[2]) : 0;
  if (what == "store") {
    pickbed::tests::MeasureStore(number > 0 ? number : 10000);
  } else if (what == "kills") {
    pickbed::tests::MeasureKills(number > 0 ? number : 50);
  } else {
    fmt::print("sweep_figures store 10000 | kills 50 | share SWEEP.yaml 8\n");
    return 1;
  }
  return 0;
}
