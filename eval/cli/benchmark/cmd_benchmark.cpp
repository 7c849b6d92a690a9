#include "eval/cli/benchmark/cmd_benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/completion/commands.h"
#include "eval/runtime/progress.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

constexpr CommandRow kTables[] = {
    {"crops", "crop methods on whole-object crops: object and orientation under each condition",
     &BenchmarkCropsCommand},
    {"bins", "all pose estimators on the same bins: recall, top-ranked pose, AP, time, memory",
     &BenchmarkBinsCommand},
    {"completion",
     "shape completion: accuracy, grasps of unknown objects, recognition of known ones",
     &BenchmarkCompletionCommand},
    {"rooms", "poses where the background is not known: precision, false poses, calibration",
     &BenchmarkRoomsCommand},
    {"all", "the tables crops and bins, one after the other", &BenchmarkAllCommand},
};

std::string BenchmarkUsage() {
  std::string text =
      "Compares published methods: trains what is missing, runs all methods on the same data, "
      "writes tables and a page.\n\nUsage: pickbed benchmark TABLE [OPTIONS]\n\nTables:\n";
  for (const CommandRow& row : kTables) text += fmt::format("  {:<12}{}\n", row.name, row.help);
  return text +
         "\n`pickbed benchmark TABLE --help` shows the options of a table.\nExample: pickbed "
         "benchmark all --small\n";
}

}  // namespace

std::span<const CommandRow> BenchmarkTables() { return kTables; }

int BenchmarkCommand(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  if (name == "--help" || name == "-h") {
    fmt::print("{}", BenchmarkUsage());
    return 0;
  }
  CheckInput(!name.empty(), "no table given; see pickbed benchmark --help");
  std::vector<std::string> names;
  for (const CommandRow& row : kTables) {
    if (row.name == name) return row.run(argc - 1, argv + 1);
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("table", name, names));
}

namespace {

struct AllArguments {
  std::vector<std::string> meshes;
  std::string unit = "m";
  std::string catalog = "objects";
  std::string out;
  bool small = false;
  int threads = 1;
};

std::vector<std::string> SharedWords(const AllArguments& arguments,
                                     const std::filesystem::path& folder) {
  std::vector<std::string> words{"--catalog", arguments.catalog,
                                 "--threads", std::to_string(arguments.threads),
                                 "--out",     folder.string()};
  if (arguments.small) words.emplace_back("--small");
  return words;
}

std::vector<std::string> CropWords(const AllArguments& arguments,
                                   const std::filesystem::path& folder) {
  std::vector<std::string> words;
  // If meshes are given, `benchmark crops` only uses objects that are named.
  if (!arguments.meshes.empty()) words = OpenCatalog(arguments.catalog).Names();
  const std::vector<std::string> shared = SharedWords(arguments, folder);
  words.insert(words.end(), shared.begin(), shared.end());
  if (!arguments.meshes.empty()) words.insert(words.end(), {"--unit", arguments.unit});
  for (const std::string& mesh : arguments.meshes) words.insert(words.end(), {"--mesh", mesh});
  return words;
}

int RunAll(const AllArguments& arguments) {
  // Report invalid meshes now, not after the bins.
  LoadMeshFiles(arguments.meshes, arguments.unit);
  const std::filesystem::path folder =
      OutFolder(arguments.out, "benchmark", arguments.small ? "-small" : "");
  const auto start = std::chrono::steady_clock::now();
  // The bins run first. Their results are stored scenario by scenario, so an interrupt during the
  // crops does not lose them.
  if (const int status = RunWords(&BenchmarkBinsCommand, "benchmark bins",
                                  SharedWords(arguments, folder / "bins"))) {
    return status;
  }
  if (const int status = RunWords(&BenchmarkCropsCommand, "benchmark crops",
                                  CropWords(arguments, folder / "crops"))) {
    return status;
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  fmt::print("both tables were made in {}\n", FormatDuration(taken.count()));
  return 0;
}

}  // namespace

int BenchmarkAllCommand(int argc, char** argv) {
  CLI::App app(
      "Makes the bin table and the crop table, including the training of missing models. After an "
      "interrupt, the same command continues.",
      "pickbed benchmark all");
  AllArguments arguments;
  CLI::Option* small =
      app.add_flag("--small", arguments.small,
                   "small variant: 3 objects, few bins and views, short training; takes minutes");
  CLI::Option* mesh =
      app.add_option("--mesh", arguments.meshes,
                     "mesh file to add as an object of the crop table; may be repeated")
          ->excludes(small);
  app.add_option("--unit", arguments.unit, "unit of length of the meshes: m, cm, mm or in")
      ->needs(mesh)
      ->capture_default_str();
  app.add_option("--catalog", arguments.catalog, "folder with your own objects")
      ->capture_default_str();
  AddThreadsArgument(app, arguments.threads);
  app.add_option("--out", arguments.out,
                 "results folder; gets the sub-folders bins and crops [results/benchmark]");
  app.footer(
      "Example: pickbed benchmark all --small\n"
      "         pickbed benchmark all --mesh drill.obj --mesh mustard.obj");
  if (!ParseArguments(app, argc, argv)) return 0;
  return RunAll(arguments);
}

}  // namespace pickbed::eval
