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
#include "eval/runtime/tables_progress.h"
#include "perception/completion_networks/network_options.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr const char* kShapesTables = "shapes";
constexpr const char* kGraspTables = "grasp";
constexpr const char* kRecognitionTables = "recognition";

// Expected duration of an item of each table on one core, s. Only the time left depends on it.
constexpr double kCompletion_s = 0.07;  // of one method
constexpr double kTrial_s = 7;
constexpr double kBin_s = 15;

constexpr char kGalleryFolder[] = "recognition";

struct BenchmarkRequest {
  CompletionBenchmarkOptions shapes;
  RecognitionOptions recognition;
  CompletedGraspsOptions grasps;
  std::vector<std::string> tables{kShapesTables, kGraspTables, kRecognitionTables};
  std::string out;

  bool Has(const char* name) const {
    return std::find(tables.begin(), tables.end(), name) != tables.end();
  }
};

// Returns the tables in their order, with their expected efforts.
std::vector<TableEffort> Efforts(const BenchmarkRequest& request) {
  const CompletionBenchmarkOptions& shapes = request.shapes;
  const CompletedGraspsOptions& grasps = request.grasps;
  const RecognitionOptions& recognition = request.recognition;
  const auto count = [](const auto& names) { return static_cast<int>(names.size()); };
  std::vector<TableEffort> tables;
  if (request.Has(kShapesTables)) {
    // The number of shapes is not known yet, but this is the first table.
    tables.push_back(
        {kShapesTables, "shape", 0, 2 * shapes.views * count(shapes.methods) * kCompletion_s});
  }
  if (request.Has(kGraspTables)) {
    tables.push_back(
        {kGraspTables, "trial", count(grasps.planners) * (grasps.single + grasps.bins), kTrial_s});
  }
  if (request.Has(kRecognitionTables)) {
    tables.push_back(
        {kRecognitionTables, "bin", recognition.bins * count(recognition.scenarios), kBin_s});
  }
  return tables;
}

// Makes the next table with a function that shows its progress and returns whether to go on.
template <typename Work>
auto MakeTable(TablesProgress& progress, Work work) {
  ProgressLine line;
  auto result = work([&](int done, int total) {
    line.Show(progress.State(done, total));
    return !Interrupted();
  });
  progress.EndTable(line.elapsed_s());
  return result;
}

// Each table is written as soon as it is made. An interrupted table has what was done until then.
int RunBenchmark(const BenchmarkRequest& request) {
  // A mistake in the options of a later table is reported before the first one, which takes
  // minutes.
  if (request.Has(kRecognitionTables)) CheckRecognition(request.recognition);
  if (request.Has(kGraspTables)) CheckCompletedGrasps(request.grasps);
  const std::filesystem::path folder = OutFolder(request.out, "completion");
  MakeFolder(folder);
  CatchInterrupts();
  TablesProgress progress(Efforts(request));
  HtmlPage page("Shape completion");
  std::string unwritten;
  const auto write_page = [&] {
    if (Interrupted()) page.Note("The benchmark was stopped here.");
    unwritten = WritePage(folder / kIndexPage, page);
  };
  if (request.Has(kShapesTables)) {
    const CompletionBenchmark benchmark = MakeTable(progress, [&](auto on_progress) {
      return RunCompletionBenchmark(request.shapes, on_progress);
    });
    fmt::print("{}", CompletionTableText(benchmark));
    AddCompletionBenchmark(folder, benchmark, request.shapes, page);
    write_page();
  }
  if (request.Has(kGraspTables) && !Interrupted()) {
    const CompletedGrasps grasps = MakeTable(progress, [&](auto on_progress) {
      return RunCompletedGrasps(request.grasps, on_progress);
    });
    fmt::print("{}", CompletedGraspsText(grasps));
    WriteFileAtomically(folder / kCompletedGraspsFile, CompletedGraspsCsv(grasps));
    WriteFileAtomically(folder / kCompletedGraspsShapesFile, CompletedGraspsShapesCsv(grasps));
    AddCompletedGrasps(folder, grasps, page);
    write_page();
  }
  if (request.Has(kRecognitionTables) && !Interrupted()) {
    RecognitionOptions options = request.recognition;
    options.pictures = folder / kGalleryFolder;
    const Recognition recognition =
        MakeTable(progress, [&](auto on_progress) { return RunRecognition(options, on_progress); });
    fmt::print("{}", RecognitionText(recognition));
    WriteFileAtomically(folder / kRecognitionFile, RecognitionCsv(recognition));
    WriteFileAtomically(folder / kRecognitionBinsFile, RecognitionBinsCsv(recognition));
    AddRecognition(recognition, kGalleryFolder, page);
    write_page();
  }
  const bool has_page = SayIfUnwritten(unwritten);
  fmt::print("wrote {}\n", (has_page ? folder / kIndexPage : folder).string());
  return Interrupted() ? kExitInterrupted : 0;
}

// Sets the numbers of the small variant, unless they are given.
void MakeSmall(const CLI::App& app, BenchmarkRequest& request) {
  const auto set = [&](const char* option, auto& value, auto small_value) {
    if (app.count(option) == 0) value = std::move(small_value);
  };
  using Names = std::vector<std::string>;
  set("--shapes", request.shapes.shapes, 1);
  set("--views", request.shapes.views, 1);
  set("--cells", request.shapes.cells, 32);
  set("--planners", request.grasps.planners, Names{"completed", "cloud_antipodal"});
  set("--single-drops", request.grasps.single, 2);
  set("--grasp-bins", request.grasps.bins, 1);
  set("--scenarios", request.recognition.scenarios, Names{"deep_rod"});
  set("--bins", request.recognition.bins, 1);
  set("--completions", request.recognition.completions, Names{"none", "network"});
}

}  // namespace

int BenchmarkCompletionCommand(int argc, char** argv) {
  CLI::App app(
      "Completes views of test shapes with all methods: IoU, surface distances, calibration and "
      "time, for seen and unseen shapes, clean and occluded. Measures what completion is worth "
      "for grasps of unknown objects and for the recognition of known ones. All tables are on one "
      "page. With the defaults, one core takes about 20 minutes. Each table is written when it "
      "is made, and Ctrl-C keeps what is done.",
      "pickbed benchmark completion");
  BenchmarkRequest request;
  CompletionBenchmarkOptions& options = request.shapes;
  request.recognition.scenarios = {"deep_bracket", "deep_elbow", "deep_mug", "deep_rod"};
  std::string data;
  bool small = false;
  app.add_option("--tables", request.tables,
                 "tables to make, separated by commas: shapes (accuracy of completed shapes), "
                 "grasp (picks of unknown objects), recognition (of known objects with and "
                 "without completion)")
      ->delimiter(',')
      ->check(CLI::IsMember({kShapesTables, kGraspTables, kRecognitionTables}))
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
  app.add_flag(
      "--small", small,
      "small variant: one shape and one view of each kind with 32 cells, two drops and one bin of "
      "grasps, one bin of recognition, with fewer planners, scenarios and completions; takes about "
      "three minutes of one core");
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
  if (small) MakeSmall(app, request);
  request.grasps.pictures = true;
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
