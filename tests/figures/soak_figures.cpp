// Whether a process that runs trials for long holds on to memory or files, on stdout:
//   soak_figures TRIALS SCENARIO [KEY=VALUE]...
// SCENARIO is a preset or a file. Trials run one after the other in this process and are written to
// a store in a temporary folder, as a worker does. Ends with 1 when the memory at the end is 5 %
// over that after a tenth of the trials, or more files are open.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/command_line.h"
#include "eval/memory.h"
#include "eval/results_store.h"
#include "eval/trial.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

constexpr double kMayGrow = 0.05;  // share of the memory that was held

int OpenFiles() {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    count += !file.path().empty();
  }
  return count;
}

struct Held {
  double mib = 0;
  int files = 0;
};
Held HeldNow() { return {static_cast<double>(ResetPeakMemory()) / (1 << 20), OpenFiles()}; }

int Soak(int trials, const ScenarioArguments& arguments) {
  const LoadedScenario scenario = LoadScenarioArguments(arguments);
  const TemporaryFolder folder;
  ResultsStore store(folder.path(), "soak");
  TrialRunner runner(scenario.spec, scenario.objects);
  const int early = trials / 10;
  Held before;
  fmt::print("{:>7} {:>10} {:>6}\n", "trials", "memory MiB", "files");
  for (int trial = 0; trial < trials; ++trial) {
    store.Write(runner.Run(trial));
    if (trial + 1 == early) before = HeldNow();
    if ((trial + 1) % early != 0) continue;
    const Held held = HeldNow();
    fmt::print("{:>7} {:>10.1f} {:>6}\n", trial + 1, held.mib, held.files);
    std::fflush(stdout);
  }
  const Held after = HeldNow();
  fmt::print("memory grew by {:.1f} %, open files by {}\n", 100 * (after.mib / before.mib - 1),
             after.files - before.files);
  return after.mib > (1 + kMayGrow) * before.mib || after.files > before.files ? 1 : 0;
}

}  // namespace
}  // namespace pickbed

int main(int argc, char** argv) {
  constexpr int kFewest = 20;
  const int trials = argc > 1 ? std::atoi(argv[1]) : 0;
  if (argc < 3 || trials < kFewest) {
    fmt::print(stderr, "soak_figures TRIALS SCENARIO [KEY=VALUE]..., {} trials at least\n",
               kFewest);
    return 2;
  }
  pickbed::ScenarioArguments arguments;
  arguments.scenario = argv[2];
  arguments.settings.assign(argv + 3, argv + argc);
  return pickbed::Soak(trials, arguments);
}
