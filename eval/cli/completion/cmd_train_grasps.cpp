#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/cli/completion/commands.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/stats/roc.h"
#include "eval/success/success_training.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

struct TrainGraspsArguments {
  std::string data_folder = "data/grasps";
  std::string model_file = "models/grasps.net";
  int jobs = 1;
  std::vector<std::string> settings;
  SuccessTrainingOptions training;
};

void PrintQuality(const SuccessTrainingReport& report) {
  fmt::print("{:<10}{:>8}{:>10}{:>24}{:>8}{:>8}{:>8}{:>8}\n", "held out", "grasps", "success",
             "AUC", "ECE", "images", "best", "any");
  for (const SuccessQuality& quality : report.quality) {
    fmt::print("{:<10}{:>8}{:>8.1f} %{:>24}{:>8.3f}{:>8}{:>6.1f} %{:>6.1f} %\n",
               quality.kind == GroupKind::kDeep ? "deep" : "shallow", quality.grasps,
               100 * quality.base_rate, AucText({quality.auc, quality.auc_ci95}),
               quality.calibration_error.value, quality.images, 100 * quality.best,
               100 * quality.any);
  }
}

int Train(const TrainGraspsArguments& arguments) {
  SuccessTrainingJob job;
  job.data_folder = arguments.data_folder;
  job.model_file = arguments.model_file;
  job.jobs = arguments.jobs;
  if (job.model_file.has_parent_path()) MakeFolder(job.model_file.parent_path());
  RequireWritable(job.model_file);
  CatchInterrupts();
  SuccessTrainingReport report;
  {
    ProgressLine progress;
    job.on_group = [&](int done, int total, int done_before) {
      ProgressState state;
      state.what = "group";
      state.done = done;
      state.total = total;
      state.done_before = done_before;
      progress.Show(state);
    };
    job.stop = [] { return Interrupted(); };
    report = TrainSuccessNetwork(job, arguments.training);
  }
  if (!report.finished) {
    fmt::print(stderr,
               "pickbed: stopped; {} keeps the finished groups, repeat the same command to "
               "continue\n",
               arguments.data_folder);
    return kExitInterrupted;
  }
  PrintQuality(report);
  fmt::print(
      "wrote {} ({} bytes), trained on {} grasps\nuse it with --set planner.success_model={}\n",
      arguments.model_file, std::filesystem::file_size(job.model_file), report.grasps,
      arguments.model_file);
  return 0;
}

}  // namespace

int TrainGraspsCommand(int argc, char** argv) {
  CLI::App app(
      "Trains the network that rates grasps of unknown objects. Grasps are executed in copies of "
      "simulated bins of objects of seen families: deep bins (deep_unknown) and shallow rounds "
      "(clutter_unseen). Ctrl-C keeps the finished groups of bins; the same command continues.",
      "pickbed train grasps");
  TrainGraspsArguments arguments;
  app.add_option("--data", arguments.data_folder,
                 "folder for the executed grasps; all groups in it are used")
      ->capture_default_str();
  app.add_option("--out", arguments.model_file, "model file to write")->capture_default_str();
  app.add_option("--groups", arguments.training.groups,
                 "number of groups of bins; half of them are deep bins")
      ->check(CLI::Range(4, 10000))
      ->capture_default_str();
  app.add_option("--jobs", arguments.jobs, "processes that execute grasps")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--seed", arguments.training.seed, "random seed of the fit")
      ->capture_default_str();
  app.add_option("--set", arguments.settings,
                 "change a training setting: KEY=VALUE, from the list below")
      ->allow_extra_args(false);
  SuccessTrainingOptions defaults;
  app.footer("Training settings and their defaults:\n" +
             WriteSettings([&](SettingsVisitor& v) { defaults.Visit(v); }, true) +
             "\nA group takes 4 to 20 minutes of one core.\n"
             "Example: pickbed train grasps --groups 60 --jobs 8");
  if (!ParseArguments(app, argc, argv)) return 0;
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { arguments.training.Visit(v); });
  }
  return Train(arguments);
}

}  // namespace pickbed::eval
