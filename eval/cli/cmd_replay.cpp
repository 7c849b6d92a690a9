#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/replay/replay.h"
#include "eval/replay/stage_files.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr int kDiffers = 1;

void SayWhatChanged(const RecordedTrial& recorded) {
  for (const std::string& change : recorded.changes) {
    fmt::print("changed since the trial ran: {}\n", change);
  }
  if (recorded.crashed) {
    fmt::print("no stage was recorded because the worker process of this trial crashed: {}\n",
               recorded.crashed->why);
  }
}

}  // namespace

int ReplayCommand(int argc, char** argv) {
  CLI::App app(
      "Repeats one trial from its record, compares the hash of each stage of each attempt, and "
      "names the first stage that differs. Writes all stages: pictures, point clouds (PLY) and the "
      "scene (GLB). The exit status is 1 if a stage differs.",
      "pickbed replay");
  std::string address_text, out, catalog = "objects";
  app.add_option("RUN#TRIAL", address_text,
                 "results folder and number of the trial, for example results/demo#2")
      ->required();
  app.add_option("--out", out, "folder for the files [RUN/replay/trial_NNNN]");
  app.add_option("--catalog", catalog, "folder with your own objects")->capture_default_str();
  app.footer("Example: pickbed replay results/demo#2");
  if (!ParseArguments(app, argc, argv)) return 0;

  const TrialAddress address = ParseTrialAddress(address_text);
  const RecordedTrial recorded = ReadRecordedTrial(address, catalog);
  SayWhatChanged(recorded);
  const std::filesystem::path folder =
      out.empty() ? address.run / kReplayFolder / fmt::format("trial_{:04}", address.trial)
                  : std::filesystem::path(out);
  StageFiles files(folder);
  ReplayReport report;
  {
    ProgressLine progress;
    report = ReplayTrial(recorded, &files, [&](std::string_view what, double share) {
      progress.Show(fmt::format("{}: {:.0f} %", what, 100 * share));
    });
  }
  WriteFileAtomically(folder / "stages.csv", ReplayCsv(report));
  fmt::print("{}stages in {}\n", ReplayTable(report), folder.string());
  return report.FirstDifference() == nullptr ? 0 : kDiffers;
}

}  // namespace pickbed::eval
