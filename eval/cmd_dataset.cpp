#include <fmt/format.h>

#include "eval/bop/check.h"
#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/progress.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

int CheckPath(const std::string& path) {
  bop::CheckReport report;
  {
    ProgressLine progress;
    report = bop::CheckDataset(
        path, [&](const std::string& scene) { progress.Show("looking at " + scene); });
  }
  for (const std::string& fault : report.faults) fmt::print("{}\n", fault);
  fmt::print("{} objects, {} scenes, {} images, {} instances: {}\n", report.objects, report.scenes,
             report.images, report.instances,
             report.faults.empty() ? "no fault" : fmt::format("{} faults", report.faults.size()));
  CheckInput(report.faults.empty(),
             fmt::format("{}: {} faults, listed above", path, report.faults.size()));
  return 0;
}

}  // namespace

int DatasetCommand(int argc, char** argv) {
  CLI::App app("Checks data sets in BOP's layout.", "pickbed dataset");
  app.require_subcommand(1);
  app.footer("Example: pickbed dataset check bop/ycbv");
  CLI::App* check = app.add_subcommand("check", "lists what is wrong with any BOP data set");
  std::string path;
  check->add_option("PATH", path, "folder with models/, camera.json and test/ or train*/")
      ->required();
  check->footer("Example: pickbed dataset check bop/ycbv");
  if (!ParseArguments(app, argc, argv)) return 0;
  return CheckPath(path);
}

}  // namespace pickbed
