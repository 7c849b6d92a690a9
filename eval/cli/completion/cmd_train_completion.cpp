#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/cli/completion/commands.h"
#include "eval/completion/sensors.h"
#include "eval/completion/training_page.h"
#include "eval/page/html.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "perception/completion/completion_training.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr int kExitStopped = kExitInterrupted;

struct TrainCompletionArguments {
  std::vector<std::string> domains{"machine", "supermarket"};
  std::vector<std::string> sensors{"ideal", "structured_light", "active_stereo", "time_of_flight",
                                   "kinect_v1"};
  std::string model_file = "models/completion.net";
  std::string report_folder;
  bool resume = false;
  std::vector<std::string> settings;
  CompletionTrainingOptions training;
};

std::string CountText(const CompletionProgress& state) {
  return fmt::format("{} {}/{}", state.phase, state.done, state.total);
}

std::string ProgressText(const CompletionProgress& state) {
  std::string text = CountText(state);
  if (state.loss > 0) text += fmt::format("  loss {:.4f}", state.loss);
  if (state.iou >= 0) text += fmt::format("  held-out IoU {:.3f}", state.iou);
  return text + fmt::format("  left {}", FormatDuration(state.seconds_left));
}

void PrintQuality(const CompletionReport& report) {
  const CompletionMeasurement& last = report.measurements.back();
  fmt::print("{:<16}{:>8}{:>11}{:>14}\n", "held-out views", "loss", "IoU clean", "IoU occluded");
  for (int i = 0; i < kHeldOutSplitCount; ++i) {
    const CompletionQuality& quality = last.splits[i];
    fmt::print("{:<16}{:>8.4f}{:>11.3f}{:>14.3f}\n", kHeldOutSplits[i], quality.loss,
               quality.iou_clean, quality.iou_occluded);
  }
}

// A name given twice would have twice the weight in the training.
void RequireDifferent(const char* option, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    CheckInput(std::ranges::count(names, name) == 1,
               fmt::format("{}: {} is given twice; give it once", option, name));
  }
}

int Train(const TrainCompletionArguments& arguments) {
  RequireDifferent("--domain", arguments.domains);
  RequireDifferent("--sensor", arguments.sensors);
  const std::filesystem::path model_file = arguments.model_file;
  const std::filesystem::path checkpoint = model_file.string() + ".checkpoint";
  CheckInput(
      !arguments.resume || std::filesystem::exists(checkpoint),
      fmt::format("no {} to resume from; remove --resume to start anew", checkpoint.string()));
  CompletionJob job;
  for (const std::string& domain : arguments.domains) {
    job.domains.push_back(ShapeDomainFromName(domain));
  }
  job.sensors = DepthSensorsNamed(arguments.sensors);
  job.sensor_names = arguments.sensors;
  job.model_file = model_file;
  job.checkpoint = checkpoint;
  job.resume = arguments.resume;
  if (model_file.has_parent_path()) MakeFolder(model_file.parent_path());
  RequireWritable(model_file);
  CatchInterrupts();
  CompletionReport report;
  {
    ProgressLine progress;
    job.on_progress = [&](const CompletionProgress& state) {
      progress.ShowTimed(ProgressText(state), CountText(state));
      return !Interrupted();
    };
    report = TrainCompletion(job, arguments.training);
  }
  if (!report.finished) {
    if (report.has_checkpoint) {
      fmt::print(stderr,
                 "pickbed: stopped; {} is written, repeat the same command with --resume to "
                 "continue\n",
                 checkpoint.string());
    } else {
      fmt::print(stderr, "pickbed: stopped before anything was trained that could be kept\n");
    }
    return kExitStopped;
  }
  if (report.stopped_early) {
    fmt::print("stopped at step {}: the held-out views did not improve any more\n", report.steps);
  }
  PrintQuality(report);
  std::filesystem::path folder = arguments.report_folder;
  if (folder.empty()) {
    folder = model_file.parent_path() / (model_file.stem().string() + "_report");
  }
  CompletionTrainingOptions options = arguments.training;
  const std::string in_force = WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  const bool has_page = SayIfUnwritten(
      WriteCompletionTrainingPage(folder, {model_file, job, arguments.training, report, in_force}));
  std::filesystem::remove(checkpoint);
  fmt::print("report: {}\n", (has_page ? folder / kIndexPage : folder).string());
  fmt::print("wrote {} ({} bytes) after {}\nuse it with --set planner.completion={}\n",
             model_file.string(), std::filesystem::file_size(model_file),
             FormatDuration(report.seconds), model_file.string());
  return 0;
}

}  // namespace

int TrainCompletionCommand(int argc, char** argv) {
  CLI::App app(
      "Trains the network that completes the shapes of unknown objects from one view. Views of "
      "sampled shapes are made during the training. Ctrl-C writes a checkpoint.",
      "pickbed train completion");
  TrainCompletionArguments arguments;
  app.add_option("--domain", arguments.domains, "shape domains, separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--sensor", arguments.sensors,
                 "sensor profiles, separated by commas; each view uses one of them")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--out", arguments.model_file, "model file to write")->capture_default_str();
  app.add_option("--report", arguments.report_folder,
                 "folder of the report page [beside the model file, <model>_report]");
  app.add_flag("--resume", arguments.resume,
               "continue from the checkpoint of an interrupted training");
  app.add_option("--minutes", arguments.training.max_minutes, "time limit, minutes; 0 = none")
      ->check(WithoutUpperLimit())
      ->capture_default_str();
  app.add_option("--threads", arguments.training.threads,
                 "threads that make views beside the training; the model does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_option("--seed", arguments.training.seed,
                 "random seed; the same seed gives the same model, unless --minutes is given")
      ->capture_default_str();
  app.add_option("--set", arguments.settings,
                 "change a training setting: KEY=VALUE, from the list below")
      ->allow_extra_args(false);
  CompletionTrainingOptions defaults;
  app.footer("Training settings and their defaults:\n" +
             WriteSettings([&](SettingsVisitor& v) { defaults.Visit(v); }, true) +
             "\nExample: pickbed train completion --domain machine,supermarket --minutes 30");
  if (!ParseArguments(app, argc, argv)) return 0;
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { arguments.training.Visit(v); });
  }
  return Train(arguments);
}

}  // namespace pickbed::eval
