#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "eval/benchmark_commands.h"
#include "eval/command_line.h"
#include "eval/progress.h"

namespace pickbed {
namespace {

struct AllArguments {
  std::vector<std::string> meshes;
  std::string unit = "m";
  std::string catalog = "objects";
  std::string out;
  bool small = false;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
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
  // Beside meshes `benchmark crops` takes no part that is not named.
  if (!arguments.meshes.empty()) words = OpenCatalog(arguments.catalog).Names();
  const std::vector<std::string> shared = SharedWords(arguments, folder);
  words.insert(words.end(), shared.begin(), shared.end());
  if (!arguments.meshes.empty()) words.insert(words.end(), {"--unit", arguments.unit});
  for (const std::string& mesh : arguments.meshes) words.insert(words.end(), {"--mesh", mesh});
  return words;
}

int RunAll(const AllArguments& arguments) {
  // What is wrong with them is better said now than after the bins.
  LoadMeshFiles(arguments.meshes, arguments.unit);
  const std::filesystem::path folder =
      OutFolder(arguments.out, "benchmark", arguments.small ? "-small" : "");
  const auto start = std::chrono::steady_clock::now();
  // The bins first: what is measured of them is kept scenario by scenario, so that a stop among the
  // crops loses none of it.
  if (const int status = RunWords(&BenchmarkBinsCommand, "benchmark bins",
                                  SharedWords(arguments, folder / "bins"))) {
    return status;
  }
  if (const int status = RunWords(&BenchmarkCropsCommand, "benchmark crops",
                                  CropWords(arguments, folder / "crops"))) {
    return status;
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  fmt::print("both tables in {}\n", FormatDuration(taken.count()));
  return 0;
}

}  // namespace

int BenchmarkAllCommand(int argc, char** argv) {
  CLI::App app(
      "The bin table and the crop table, from training to page. Stopped, the same command goes on.",
      "pickbed benchmark all");
  AllArguments arguments;
  CLI::Option* small = app.add_flag("--small", arguments.small,
                                    "3 parts, few bins and views, short training: minutes");
  CLI::Option* mesh = app.add_option("--mesh", arguments.meshes,
                                     "a mesh file as a further part of the crop table; repeatable")
                          ->excludes(small);
  app.add_option("--unit", arguments.unit, "of the meshes: m, cm, mm, in")
      ->needs(mesh)
      ->capture_default_str();
  app.add_option("--catalog", arguments.catalog, "your own parts")->capture_default_str();
  app.add_option("--threads", arguments.threads, "at most; results do not depend on it")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--out", arguments.out, "folder, with bins and crops in it [results/benchmark]");
  app.footer(
      "Example: pickbed benchmark all --small\n"
      "         pickbed benchmark all --mesh drill.obj --mesh mustard.obj");
  if (!ParseArguments(app, argc, argv)) return 0;
  return RunAll(arguments);
}

}  // namespace pickbed
