#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/benchmark/completed_grasps.h"
#include "eval/benchmark/recognition.h"
#include "eval/cli/arguments.h"
#include "eval/cli/completion/commands.h"
#include "eval/completion/benchmark_report.h"
#include "eval/completion/test_shapes.h"
#include "eval/page/html.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "perception/completion_networks/network_options.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr const char* kShapesTables = "shapes";
constexpr const char* kRecognitionTables = "recognition";
constexpr const char* kGraspTables = "grasp";

struct BenchmarkRequest {
  CompletionBenchmarkOptions shapes;
  RecognitionOptions recognition;
  CompletedGraspsOptions grasps;
  std::vector<std::string> tables{kShapesTables};
  std::string out;

  bool Has(const char* name) const {
    return std::find(tables.begin(), tables.end(), name) != tables.end();
  }
};

// Shows progress and returns whether to go on.
std::function<bool(int, int)> Shown(ProgressLine& progress, std::string what) {
  return [&progress, what = std::move(what)](int done, int total) {
    ProgressState state;
    state.what = what;
    state.done = done;
    state.total = total;
    progress.Show(state);
    return !Interrupted();
  };
}

int RunBenchmark(const BenchmarkRequest& request) {
  // A mistake in the options of a later table is reported before the first one, which takes
  // minutes.
  if (request.Has(kRecognitionTables)) CheckRecognition(request.recognition);
  if (request.Has(kGraspTables)) CheckCompletedGrasps(request.grasps);
  const std::filesystem::path folder = OutFolder(request.out, "completion");
  MakeFolder(folder);
  CatchInterrupts();
  HtmlPage page("Shape completion");
  if (request.Has(kShapesTables)) {
    CompletionBenchmark benchmark;
    {
      ProgressLine progress;
      benchmark = RunCompletionBenchmark(request.shapes, Shown(progress, "shape"));
    }
    if (Interrupted()) return kExitInterrupted;
    fmt::print("{}", CompletionTableText(benchmark));
    AddCompletionBenchmark(folder, benchmark, request.shapes, page);
  }
  if (request.Has(kRecognitionTables)) {
    Recognition recognition;
    {
      ProgressLine progress;
      recognition = RunRecognition(request.recognition, Shown(progress, "bin"));
    }
    // An interrupted comparison is valid for the bins so far.
    fmt::print("{}", RecognitionText(recognition));
    WriteFileAtomically(folder / kRecognitionFile, RecognitionCsv(recognition));
    WriteFileAtomically(folder / kRecognitionBinsFile, RecognitionBinsCsv(recognition));
    AddRecognition(recognition, page);
  }
  if (request.Has(kGraspTables) && !Interrupted()) {
    CompletedGrasps grasps;
    {
      ProgressLine progress;
      grasps = RunCompletedGrasps(request.grasps, Shown(progress, "trial"));
    }
    // An interrupted comparison is valid for the trials so far.
    fmt::print("{}", CompletedGraspsText(grasps));
    WriteFileAtomically(folder / kCompletedGraspsFile, CompletedGraspsCsv(grasps));
    WriteFileAtomically(folder / kCompletedGraspsShapesFile, CompletedGraspsShapesCsv(grasps));
    AddCompletedGrasps(grasps, page);
  }
  const bool has_page = SayIfUnwritten(WritePage(folder / kIndexPage, page));
  fmt::print("wrote {}\n", (has_page ? folder / kIndexPage : folder).string());
  return Interrupted() ? kExitInterrupted : 0;
}

}  // namespace

int BenchmarkCompletionCommand(int argc, char** argv) {
  CLI::App app(
      "Completes views of test shapes with all methods: IoU, surface distances, calibration and "
      "time, for seen and unseen shapes, clean and occluded. Measures what completion is worth "
      "for the recognition of known objects and for grasps of unknown ones.",
      "pickbed benchmark completion");
  BenchmarkRequest request;
  CompletionBenchmarkOptions& options = request.shapes;
  request.recognition.scenarios = {"deep_bracket", "deep_elbow", "deep_mug", "deep_rod"};
  std::string data;
  bool small = false;
  app.add_option("--tables", request.tables,
                 "tables to make, separated by commas: shapes (accuracy of completed shapes), "
                 "recognition (of known objects with and without completion), grasp (picks of "
                 "unknown objects)")
      ->delimiter(',')
      ->check(CLI::IsMember({kShapesTables, kRecognitionTables, kGraspTables}))
      ->capture_default_str();
  app.add_option(
         "--methods", options.methods,
         "methods, separated by commas; the first is compared with the others; truth is the "
         "true shape [all that have a model or need none]")
      ->delimiter(',');
  app.add_option("--sets", options.sets,
                 "test sets, separated by commas: seen, unseen_sizes, outside, unseen_families, "
                 "catalog, ycb, industrial [all]")
      ->delimiter(',');
  app.add_option("--data", data,
                 "folder with the folders ycb and industrial of meshes; without it these sets are "
                 "skipped");
  app.add_option("--model", options.models,
                 "model files of methods network and vae, separated by commas; each method uses "
                 "the first of its kind")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--sensor", options.sensor, "sensor profile of the views")->capture_default_str();
  app.add_option("--min-px", options.min_diameter_px,
                 "smallest diameter of a shape in the image, px")
      ->check(CLI::Range(20, 140))
      ->capture_default_str();
  app.add_option("--level", options.level,
                 "probability above which a cell is full; 0 = the one with the largest expected "
                 "IoU for each completion")
      ->check(CLI::Range(0.0, 0.99))
      ->capture_default_str();
  app.add_option("--shapes", options.shapes, "shapes of each family")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--views", options.views, "clean views of each shape, and as many occluded ones")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--cells", options.cells, "cells along each axis of the cube")
      ->check(CLI::Range(8, 256))
      ->capture_default_str();
  app.add_flag("--small", small, "one shape and one view of each kind, 32 cells");
  app.add_option("--seed", options.seed, "random seed of the views")->capture_default_str();
  app.add_option("--scenarios", request.recognition.scenarios,
                 "bins of the recognition tables, separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--bins", request.recognition.bins,
                 "bins of each scenario of the recognition tables")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option(
         "--completions", request.recognition.completions,
         "methods of the recognition tables, separated by commas; the first is the reference")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--mode", request.recognition.mode, "search mode of estimator descriptor")
      ->check(CLI::IsMember({"fast", "accurate"}))
      ->capture_default_str();
  app.add_option("--bin-seed", request.recognition.seed, "random seed of these bins")
      ->capture_default_str();
  app.add_option("--planners", request.grasps.planners,
                 "planners of the grasp tables, separated by commas; truth = completed with the "
                 "true shapes; the first is the reference")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--grasp-scenario", request.grasps.scenario,
                 "scenario with a pool of shapes for the grasp tables")
      ->capture_default_str();
  app.add_option("--single-drops", request.grasps.single,
                 "drops of single shapes for the grasp tables")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--grasp-bins", request.grasps.bins, "bins of the grasp tables")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--grasp-seed", request.grasps.seed, "random seed of the grasp tables")
      ->capture_default_str();
  app.add_option("--out", request.out, "results folder [results/completion]");
  app.footer("Example: pickbed benchmark completion --small --methods local_thickness,skirt");
  if (!ParseArguments(app, argc, argv)) return 0;
  if (small) {
    options.shapes = options.views = 1;
    options.cells = 32;
  }
  if (options.methods.empty()) options.methods = MethodsWith(options.models);
  if (options.sets.empty()) options.sets = TestSetNames();
  options.data_folder = data;
  if (request.Has(kRecognitionTables) || request.Has(kGraspTables)) {
    const std::string model = ModelOfKind(options.models, CompletionNetworkOptions().kind);
    if (!model.empty()) {
      request.recognition.model = model;
      request.grasps.completion = TrainedFile(model);
    }
  }
  return RunBenchmark(request);
}

}  // namespace pickbed::eval
