#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/cli/completion/commands.h"
#include "eval/completion/benchmark_report.h"
#include "eval/completion/test_shapes.h"
#include "eval/page/html.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"

namespace pickbed::eval {
namespace {

int RunBenchmark(const CompletionBenchmarkOptions& options, const std::string& out) {
  const std::filesystem::path folder = OutFolder(out, "completion");
  CatchInterrupts();
  CompletionBenchmark benchmark;
  {
    ProgressLine progress;
    benchmark = RunCompletionBenchmark(options, [&](int done, int total) {
      ProgressState state;
      state.what = "shape";
      state.done = done;
      state.total = total;
      progress.Show(state);
      return !Interrupted();
    });
  }
  if (Interrupted()) return kExitInterrupted;
  fmt::print("{}", CompletionTableText(benchmark));
  const bool has_page = SayIfUnwritten(WriteCompletionBenchmark(folder, benchmark, options));
  fmt::print("wrote {}\n", (has_page ? folder / kIndexPage : folder).string());
  return 0;
}

}  // namespace

int BenchmarkCompletionCommand(int argc, char** argv) {
  CLI::App app(
      "Completes views of test shapes with all methods: IoU, surface distances, calibration and "
      "time, for seen and unseen shapes, clean and occluded.",
      "pickbed benchmark completion");
  CompletionBenchmarkOptions options;
  std::string out, data;
  bool small = false;
  app.add_option("--methods", options.methods,
                 "methods, separated by commas; the first is compared with the others [all]")
      ->delimiter(',');
  app.add_option("--sets", options.sets,
                 "test sets, separated by commas: seen, unseen_sizes, outside, unseen_families, "
                 "catalog, ycb, industrial [all]")
      ->delimiter(',');
  app.add_option("--data", data,
                 "folder with the folders ycb and industrial of meshes; without it these sets are "
                 "skipped");
  app.add_option("--model", options.model, "model file of method network")->capture_default_str();
  app.add_option("--sensor", options.sensor, "sensor profile of the views")->capture_default_str();
  app.add_option("--min-px", options.min_diameter_px,
                 "smallest diameter of a shape in the image, px")
      ->check(CLI::Range(20, 140))
      ->capture_default_str();
  app.add_option("--level", options.level, "probability above which a cell is full")
      ->check(CLI::Range(0.01, 0.99))
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
  app.add_option("--out", out, "results folder [results/completion]");
  app.footer("Example: pickbed benchmark completion --small --methods local_thickness,skirt");
  if (!ParseArguments(app, argc, argv)) return 0;
  if (small) {
    options.shapes = options.views = 1;
    options.cells = 32;
  }
  if (options.methods.empty()) {
    for (const CompleterRow& row : CompleterTable()) options.methods.push_back(row.name);
  }
  if (options.sets.empty()) options.sets = TestSetNames();
  options.data_folder = data;
  return RunBenchmark(options, out);
}

}  // namespace pickbed::eval
