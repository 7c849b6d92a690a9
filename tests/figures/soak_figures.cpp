// Tests whether a process that runs many trials leaks memory or files, printed to stdout:
//   soak_figures TRIALS SCENARIO [KEY=VALUE]...
// SCENARIO is a preset or a file. Trials run one after the other in this process and are written to
// a store in a temporary folder, as in a worker. The exit status is 1 if the final memory exceeds
// the memory after a tenth of the trials by 5 %, or if more files are open.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/runtime/process.h"
#include "eval/store/results_store.h"
#include "eval/trial/trial.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

constexpr double kMayGrow = 0.05;  // fraction of the memory in use

int OpenFiles() {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    count += !file.path().empty();
  }
  return count;
}

struct ResourceUse {
  double mib = 0;
  int files = 0;
};
ResourceUse CurrentUse() {
  return {static_cast<double>(ResetPeakMemory()) / (1 << 20), OpenFiles()};
}

int Soak(int trials, const ScenarioRequest& arguments) {
  const LoadedScenario scenario = FindScenario(arguments);
  const TemporaryFolder folder;
  ResultsStore store(folder.path(), "soak");
  TrialRunner runner(scenario.spec, scenario.objects);
  const int early = trials / 10;
  ResourceUse before;
  fmt::print("{:>7} {:>10} {:>6}\n", "trials", "memory MiB", "files");
  for (int trial = 0; trial < trials; ++trial) {
    store.Write(runner.Run(BinIndex(trial)));
    if (trial + 1 == early) before = CurrentUse();
    if ((trial + 1) % early != 0) continue;
    const ResourceUse use = CurrentUse();
    fmt::print("{:>7} {:>10.1f} {:>6}\n", trial + 1, use.mib, use.files);
    std::fflush(stdout);
  }
  const ResourceUse after = CurrentUse();
  fmt::print("memory grew by {:.1f} %, open files by {}\n", 100 * (after.mib / before.mib - 1),
             after.files - before.files);
  return after.mib > (1 + kMayGrow) * before.mib || after.files > before.files ? 1 : 0;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  constexpr int kFewest = 20;
  const int trials = argc > 1 ? std::atoi(argv[1]) : 0;
  if (argc < 3 || trials < kFewest) {
    fmt::print(stderr, "soak_figures TRIALS SCENARIO [KEY=VALUE]..., {} trials at least\n",
               kFewest);
    return 2;
  }
  pickbed::scenes::ScenarioRequest arguments;
  arguments.scenario = argv[2];
  arguments.settings.assign(argv + 3, argv + argc);
  return pickbed::tests::Soak(trials, arguments);
}
