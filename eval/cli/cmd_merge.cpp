#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/runtime/process.h"
#include "eval/sweep/merge_shards.h"

namespace pickbed::eval {

int MergeCommand(int argc, char** argv) {
  CLI::App app("Merges the results of shards, or puts runs with different settings side by side.",
               "pickbed merge");
  std::vector<std::string> folders;
  std::string out;
  MergeOptions options;
  app.add_option("RUN", folders, "results folders: OUT/shards/*, or runs and sweeps")->required();
  app.add_option("--out", out, "folder for the merged results")->required();
  app.add_flag("--compare", options.compare,
               "accept different settings: the configurations of all runs are listed side by side");
  app.footer("Example: pickbed merge results/s/shards/* --out results/s");
  if (!ParseArguments(app, argc, argv)) return 0;
  const MergeReport report =
      MergeStores({folders.begin(), folders.end()}, std::filesystem::path(out), options);
  fmt::print("{}\n{} trials{}{} in {}\n", SweepTable(report.configurations), report.trials,
             report.missing > 0 ? fmt::format(", {} are missing", report.missing) : "",
             report.doubled > 0 ? fmt::format(", {} were in several stores", report.doubled) : "",
             out);
  return 0;
}

}  // namespace pickbed::eval
