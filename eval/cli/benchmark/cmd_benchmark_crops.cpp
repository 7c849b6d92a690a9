#include <fmt/format.h>

#include <algorithm>

#include "eval/benchmark/crops_report.h"
#include "eval/cli/arguments.h"
#include "eval/cli/benchmark/cmd_benchmark.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/geometry/symmetry_finder.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::eval {
namespace {

struct CropArguments {
  std::vector<std::string> names;       // names in the catalog; empty = all
  std::vector<std::string> meshes;      // paths of mesh files
  std::string unit = "m";               // unit of the meshes
  std::vector<std::string> methods;     // empty = all
  std::vector<std::string> conditions;  // empty = all
  std::vector<std::string> settings;
  std::string catalog = "objects";
  std::string out;
  bool small = false;
  int threads = 1;
};

// Selection of --small: dissimilar objects, few views, one network.
constexpr const char* kSmallInstances[] = {"bracket", "pipe_tee", "mug"};
constexpr const char* kSmallMethods[] = {"wohlhart", "hog", "linemod", "random"};
constexpr const char* kSmallConditions[] = {"clean", "noisy", "occluded_30"};

void MakeSmall(CropArguments& arguments, CropBenchmarkOptions& options) {
  const auto fill = [](std::vector<std::string>& names, const auto& small) {
    if (names.empty()) names.assign(std::begin(small), std::end(small));
  };
  if (arguments.meshes.empty()) fill(arguments.names, kSmallInstances);
  fill(arguments.methods, kSmallMethods);
  fill(arguments.conditions, kSmallConditions);
  options.tests = 20;
  options.icp_starts = 4;
  options.views.template_level = 2;
  options.views.train_level = 3;
  options.methods.wohlhart.anchors = 64;
  options.methods.wohlhart.iterations = 60;
  options.methods.wohlhart.mine_every = 60;
}

template <typename Rows>
std::vector<std::string> AllNames(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.push_back(row.name);
  return names;
}

ObjectSet LoadCropObjects(const CropArguments& arguments) {
  const ObjectCatalog catalog = OpenCatalog(arguments.catalog);
  ObjectSet objects;
  std::vector<std::string> names = arguments.names;
  if (names.empty() && arguments.meshes.empty()) names = catalog.Names();
  for (const std::string& name : names) objects.push_back(catalog.Load(name));
  const ObjectSet more = LoadMeshFiles(arguments.meshes, arguments.unit);
  objects.insert(objects.end(), more.begin(), more.end());
  return objects;
}

// Returns whether the page was written.
bool WriteAll(const CropBenchmark& benchmark, const ObjectSet& objects,
              CropBenchmarkOptions options, const std::filesystem::path& folder) {
  const std::string settings = WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  WriteFileAtomically(folder / kCropsFile, CropTableCsv(benchmark, objects));
  WriteFileAtomically(folder / kCropViewsFile, CropViewsCsv(benchmark, objects));
  WriteFileAtomically(folder / kTimingsFile, CropTimingsCsv(benchmark));
  WriteFileAtomically(folder / kCropDifferencesFile, CropDifferencesCsv(benchmark));
  WriteFileAtomically(folder / kCropSettingsFile, settings);
  return SayIfUnwritten(WritePage(folder / kCropsPage, CropPage(benchmark, objects, settings)));
}

CropBenchmark RunWithProgress(CropBenchmarkJob job) {
  ProgressLine progress;
  job.on_progress = [&](const std::string& what, double share) {
    const double left_s = share > 0 ? progress.elapsed_s() * (1 - share) / share : -1;
    progress.Show(
        fmt::format("{}  left {}  {}", WholePercentText(share), FormatDuration(left_s), what));
    return !Interrupted();
  };
  return RunCropBenchmark(job);
}

}  // namespace

ObjectSet LoadMeshFiles(const std::vector<std::string>& meshes, const std::string& unit) {
  ObjectSet objects;
  for (const std::string& mesh : meshes) {
    const std::filesystem::path file = mesh;
    MeshObjectSpec spec;
    spec.mesh = file;
    spec.unit = unit;
    spec.mass_kg = 1;
    auto object = std::make_shared<ObjectModel>(*LoadMeshObject(file.stem().string(), spec));
    object->symmetries_O = FindSymmetries(object->mesh_O);
    objects.push_back(std::move(object));
  }
  return objects;
}

int BenchmarkCropsCommand(int argc, char** argv) {
  CLI::App app("Runs every crop method on the same views of every object, under every condition.",
               "pickbed benchmark crops");
  CropArguments arguments;
  app.add_option("PART", arguments.names, "names of objects in the catalog; default: all objects");
  CLI::Option* mesh =
      app.add_option("--mesh", arguments.meshes, "mesh file to add as an object; may be repeated");
  app.add_option("--unit", arguments.unit, "unit of length of the meshes: m, cm, mm or in")
      ->needs(mesh)
      ->capture_default_str();
  app.add_option("--method", arguments.methods,
                 "crop methods to run, separated by commas; default: all")
      ->delimiter(',');
  app.add_option("--condition", arguments.conditions,
                 "conditions to test, separated by commas; default: all")
      ->delimiter(',');
  app.add_option("--set", arguments.settings,
                 "change a setting: KEY=VALUE, from the list below; may be repeated");
  app.add_option("--catalog", arguments.catalog, "folder with your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.out,
                 "results folder [results/crops, with --small results/crops-small]");
  app.add_flag("--small", arguments.small,
               "small variant: 3 objects, few views, short training; takes some minutes");
  AddThreadsArgument(app, arguments.threads);
  CropBenchmarkOptions options;
  app.footer("Settings and their defaults:\n" +
             WriteSettings([&](SettingsVisitor& v) { options.Visit(v); }, true) +
             "\nExample: pickbed benchmark crops --small\n"
             "         pickbed benchmark crops rod mug --method hog,wohlhart --set tests=100");
  if (!ParseArguments(app, argc, argv)) return 0;
  if (arguments.small) MakeSmall(arguments, options);
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { options.Visit(v); });
  }
  if (arguments.methods.empty()) arguments.methods = AllNames(CropMethodTable());
  if (arguments.conditions.empty()) arguments.conditions = AllNames(CropConditionTable());

  const std::filesystem::path folder =
      OutFolder(arguments.out, "crops", arguments.small ? "-small" : "");
  MakeFolder(folder / "models");
  const CropBenchmarkJob job{LoadCropObjects(arguments),
                             arguments.methods,
                             arguments.conditions,
                             options,
                             folder / "models",
                             arguments.threads,
                             {}};
  CatchInterrupts();
  const CropBenchmark benchmark = RunWithProgress(job);
  bool has_page = false;
  if (!benchmark.records.empty()) has_page = WriteAll(benchmark, job.objects, options, folder);
  if (!benchmark.finished) {
    fmt::print(stderr,
               "pickbed: interrupted; repeat the same command to continue with the networks "
               "trained so far\n");
    return kExitInterrupted;
  }
  fmt::print("{}{}{}, {} and {} in {}\n", CropTableText(benchmark),
             has_page ? fmt::format("{}, ", kCropsPage) : "", kCropsFile, kCropDifferencesFile,
             kCropViewsFile, folder.string());
  return 0;
}

}  // namespace pickbed::eval
