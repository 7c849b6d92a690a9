#include <fmt/format.h>

#include "eval/bop/check_dataset.h"
#include "eval/bop/layout.h"
#include "eval/bop/make_dataset.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/execution/methods.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

struct MakeArguments {
  ScenarioRequest scenario;
  std::string format = "bop";
  std::string out;
  MakeDatasetOptions options;
};

int Make(const MakeArguments& arguments) {
  CatchInterrupts();
  const LoadedScenario scenario = FindScenario(arguments.scenario);
  MakeDatasetOptions options = arguments.options;
  options.out = OutFolder(arguments.out, scenario.name, "-bop");
  MakeFolder(options.out);
  MakeDatasetReport report;
  double seconds = 0;
  {
    ProgressLine progress;
    const auto on_scene = [&](const MakeDatasetReport& state) {
      ProgressState shown;
      shown.what = "scene";
      shown.done = state.done;
      shown.total = options.scenes;
      shown.done_before = state.done_before;
      shown.note = fmt::format("{} images each", options.views);
      progress.Show(shown);
    };
    report = MakeDataset(scenario.spec, scenario.objects, options, on_scene, Interrupted);
    seconds = progress.elapsed_s();
  }
  if (report.stopped) {
    fmt::print(
        stderr,
        "pickbed: stopped after {} scenes; repeat the same command with --resume to continue\n",
        report.done);
    return kExitInterrupted;
  }
  if (!report.lost.empty()) {
    throw std::runtime_error(
        fmt::format("{} scenes failed, the first is scene {}: {}; --resume repeats them",
                    report.lost.size(), report.lost.front().item, report.lost.front().why));
  }
  fmt::print("{} with {} each in {} ({} made in {:.1f} s)\n", Counted(report.done, "scene"),
             Counted(options.views, "view"), options.out.string(),
             Counted((report.done - report.done_before) * options.views, "image"), seconds);
  return 0;
}

int Check(const std::string& path) {
  CheckDatasetReport report;
  {
    ProgressLine progress;
    report =
        CheckDataset(path, [&](const std::string& scene) { progress.Show("checking " + scene); });
  }
  for (const std::string& fault : report.faults) fmt::print("{}\n", fault);
  const std::string faults = Counted(report.faults.size(), "fault");
  fmt::print("{}, {}, {}, {}: {}\n", Counted(report.objects, "object"),
             Counted(report.scenes, "scene"), Counted(report.images, "image"),
             Counted(report.instances, "instance"), report.faults.empty() ? "no fault" : faults);
  CheckInput(report.faults.empty(), fmt::format("{}: {}, listed above", path, faults));
  return 0;
}

struct TruthArguments {
  std::string path, split = "test", out;
};

int WriteTruth(const TruthArguments& arguments) {
  const std::vector<DatasetEstimate> estimates = TrueEstimates(arguments.path, arguments.split);
  const std::filesystem::path parent = std::filesystem::path(arguments.out).parent_path();
  if (!parent.empty()) MakeFolder(parent);
  WriteFileAtomically(arguments.out, WriteEstimates(estimates));
  fmt::print("{} true poses in {}\n", estimates.size(), arguments.out);
  return 0;
}

void AddMakeArguments(CLI::App& make, MakeArguments& arguments) {
  MakeDatasetOptions& options = arguments.options;
  AddScenarioArguments(make, arguments.scenario);
  AddOutArgument(make, arguments.out, "-bop");
  make.add_option("--format", arguments.format, "layout of the dataset")
      ->check(CLI::IsMember({"bop"}))
      ->capture_default_str();
  make.add_option("--split", options.split,
                  "name of the folder for the scenes: train, val or test, or one of these with an "
                  "underscore and a word")
      ->check([](const std::string& name) {
        const std::string kind = name.substr(0, name.find('_'));
        const bool known = kind == "train" || kind == "val" || kind == "test";
        const bool plain = name.find('/') == std::string::npos;
        return known && plain ? std::string() : "'" + name + "' is no name of a split";
      })
      ->capture_default_str();
  make.add_option("--scenes", options.scenes, "total number of scenes")
      ->check(CLI::Range(1, 999999))
      ->capture_default_str();
  make.add_option("--views", options.views, "number of images per scene")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  AddJobsArgument(make, options.jobs, "the written files do");
  make.add_flag("--resume", options.resume, "continue a dataset whose making was interrupted");
  make.footer("Example: pickbed dataset make demo --scenes 200 --views 5 --out bop/demo");
}

}  // namespace

int DatasetCommand(int argc, char** argv) {
  CLI::App app("Makes or checks a dataset in BOP's layout, or writes its true poses.",
               "pickbed dataset");
  app.require_subcommand(1);
  app.footer("Example: pickbed dataset make demo --scenes 20 --views 5 --out bop/demo");
  MakeArguments arguments;
  CLI::App* make = app.add_subcommand("make", "make settled scenes with images, masks and poses");
  AddMakeArguments(*make, arguments);
  CLI::App* check = app.add_subcommand("check", "list the faults of a BOP dataset");
  std::string path;
  check
      ->add_option("PATH", path,
                   fmt::format("folder of the dataset, with models/, {} and test/ or train*/",
                               kDatasetCameraFile))
      ->required();
  check->footer("Example: pickbed dataset check bop/ycbv");
  TruthArguments truth_arguments;
  CLI::App* truth = app.add_subcommand(
      "truth", "write the true poses of a BOP dataset as a results file; score = visible fraction");
  truth->add_option("PATH", truth_arguments.path, "folder of the dataset")->required();
  truth->add_option("--split", truth_arguments.split, "scene folder of the dataset")
      ->capture_default_str();
  truth->add_option("--out", truth_arguments.out, "results file to write")->required();
  truth->footer("Example: pickbed dataset truth bop/demo --out results/truth.csv");
  if (!ParseArguments(app, argc, argv)) return 0;
  if (truth->parsed()) return WriteTruth(truth_arguments);
  return make->parsed() ? Make(arguments) : Check(path);
}

}  // namespace pickbed::eval
