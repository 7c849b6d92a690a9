#include <fmt/format.h>

#include <algorithm>

#include "eval/benchmark/bins.h"
#include "eval/cli/arguments.h"
#include "eval/cli/benchmark/cmd_benchmark.h"
#include "eval/cli/commands.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

constexpr int kScenes = 10;       // bins per scenario
constexpr int kSmallScenes = 10;  // all bins of --small together
const std::vector<std::string> kSmallScenarios{"bin_bracket", "bin_pipe_tee", "bin_rod"};
constexpr const char* kSmallNote =
    "Small variant: kehl, doumanoglou, union and wohlhart are trained for about a minute each, "
    "unless a trained model is in the models folder, and find fewer poses than after a full "
    "training.";

struct BinsArguments {
  std::vector<std::string> scenarios, estimators;
  std::string catalog = "objects";
  std::string out;
  bool small = false;
  int scenes = 0;  // 0 = default
  int threads = 1;
};

std::vector<std::string> AllBins() {
  std::vector<std::string> names;
  for (const std::string& name : PresetNames()) {
    if (name.starts_with("bin_")) names.push_back(name);
  }
  return names;
}

std::vector<BinMethod> ChosenMethods(const std::vector<std::string>& labels) {
  if (labels.empty()) return BinMethods();
  std::vector<BinMethod> chosen;
  for (const std::string& given : labels) {
    const std::string label = CurrentLabel(given);
    std::vector<std::string> known;
    const size_t before = chosen.size();
    for (const BinMethod& method : BinMethods()) {
      if (label == method.label) chosen.push_back(method);
      known.push_back(method.label);
    }
    if (chosen.size() == before) throw InputError(UnknownNameMessage("estimator", label, known));
  }
  return chosen;
}

std::vector<LoadedScenario> LoadBins(const BinsArguments& arguments) {
  std::vector<std::string> names = arguments.scenarios;
  if (names.empty()) names = arguments.small ? kSmallScenarios : AllBins();
  std::vector<int> scenes(names.size(), arguments.scenes > 0 ? arguments.scenes : kScenes);
  if (arguments.small && arguments.scenes == 0) {
    scenes = SharedBins(kSmallScenes, static_cast<int>(names.size()));
  }
  std::vector<LoadedScenario> scenarios;
  for (size_t i = 0; i < names.size(); ++i) {
    ScenarioRequest one;
    one.scenario = names[i];
    one.catalog = arguments.catalog;
    one.trials = scenes[i];
    scenarios.push_back(FindScenario(one));
  }
  return scenarios;
}

// Returns the objects to be found in any of the bins, each once.
ObjectSet WantedObjects(const std::vector<LoadedScenario>& scenarios) {
  ObjectSet objects;
  for (const LoadedScenario& scenario : scenarios) {
    for (size_t i = 0; i < scenario.objects.size(); ++i) {
      const auto& object = scenario.objects[i];
      const auto is_it = [&](const auto& wanted) { return wanted->name == object->name; };
      if (scenario.spec.objects[i].distractor ||
          std::any_of(objects.begin(), objects.end(), is_it)) {
        continue;
      }
      objects.push_back(object);
    }
  }
  return objects;
}

// Objects with meshes of a scenario cannot be trained by name.
void RequireInCatalog(const ObjectSet& objects, const std::string& catalog, const BinMethod& method,
                      const std::filesystem::path& folder) {
  const std::vector<std::string> known = OpenCatalog(catalog).Names();
  for (const auto& wanted : objects) {
    CheckInput(std::find(known.begin(), known.end(), wanted->name) != known.end(),
               fmt::format("object '{}' is in no catalog, so {} cannot be trained for it; add the "
                           "object with --catalog, or put a model trained for it at {}",
                           wanted->name, method.label,
                           (folder / (std::string(method.model) + ".net")).string()));
  }
}

// Adds the methods with their model files, by label, and trains missing models. Returns the exit
// status; not 0 if a training stopped.
int FindModels(const std::vector<BinMethod>& methods, const std::filesystem::path& folder,
               const ObjectSet& objects, const BinsArguments& arguments,
               std::vector<ComparedEstimator>& estimators) {
  MakeFolder(folder);
  for (const BinMethod& method : methods) {
    ComparedEstimator& estimator = estimators.emplace_back();
    estimator.label = method.label;
    estimator.spec.name = method.estimator;
    estimator.spec.mode = method.mode;
    if (std::string(method.model).empty()) continue;
    std::filesystem::path file = FindBinModel(method, folder, objects, arguments.small);
    if (file.empty()) {
      RequireInCatalog(objects, arguments.catalog, method, folder);
      file = TrainedModelFile(method, folder, objects, arguments.small);
      std::vector<std::string> words = TrainingWords(method, file, objects, arguments.small);
      words.insert(words.end(), {"--catalog", arguments.catalog});
      if (IsBegun(file)) words.push_back("--resume");
      if (const int status = RunWords(&TrainCommand, "train", words)) return status;
    }
    estimator.spec.model = file.string();
  }
  return 0;
}

// Hash of everything that the rows of a scenario depend on, except times.
std::string ScenarioKey(const LoadedScenario& scenario,
                        const std::vector<ComparedEstimator>& estimators) {
  ScenarioSpec spec = scenario.spec;
  std::string key = WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
  for (const auto& object : scenario.objects) {
    key += fmt::format("{} {:016x}\n", object->name, object->mesh_hash);
  }
  for (const ComparedEstimator& estimator : estimators) {
    uint64_t hash = 0;
    if (!estimator.spec.model.empty()) {
      const std::string bytes = ReadFileBytes(estimator.spec.model);
      hash = HashBytes(bytes.data(), bytes.size());
    }
    key += fmt::format("{} {} {} {:016x}\n", estimator.label, estimator.spec.name,
                       estimator.spec.mode, hash);
  }
  return fmt::format("{:016x}", HashBytes(key.data(), key.size()));
}

// Returns nullopt if interrupted.
std::optional<BinScenario> Measure(const LoadedScenario& scenario,
                                   const std::vector<ComparedEstimator>& estimators, int threads,
                                   ProgressLine& progress, ProgressState& state) {
  const int before = state.done;
  ComparisonJob job{scenario.spec, scenario.objects, estimators, {}, 0, threads, {}, Interrupted};
  job.on_progress = [&](std::string_view what, int done, int) {
    state.note = what == "bin" ? scenario.name : fmt::format("{}: {} %", what, done);
    if (what == "bin") state.done = before + done;
    progress.Show(state);
  };
  const std::vector<ComparedRow> rows = CompareEstimators(job);
  if (Interrupted()) return std::nullopt;
  BinScenario result{scenario.name, {}};
  for (const ComparedRow& row : rows) result.rows.push_back(BinRowOf(row));
  return result;
}

int RunBins(const BinsArguments& arguments) {
  const std::vector<BinMethod> methods = ChosenMethods(arguments.estimators);
  const std::vector<LoadedScenario> scenarios = LoadBins(arguments);
  const std::filesystem::path folder =
      OutFolder(arguments.out, arguments.small ? "benchmark-bins-small" : "benchmark-bins");
  MakeFolder(folder / "scenarios");
  CatchInterrupts();
  std::vector<ComparedEstimator> estimators;
  if (const int status =
          FindModels(methods, folder / "models", WantedObjects(scenarios), arguments, estimators)) {
    if (status == kExitInterrupted) {
      fmt::print(stderr, "pickbed: repeat the same command to continue with this training\n");
    }
    return status;
  }
  std::vector<BinScenario> done;
  {
    ProgressLine progress;
    ProgressState state;
    state.what = "bin";
    for (const LoadedScenario& scenario : scenarios) state.total += scenario.spec.trials;
    for (const LoadedScenario& scenario : scenarios) {
      const std::filesystem::path file = folder / "scenarios" / (scenario.name + ".json");
      const std::string key = ScenarioKey(scenario, estimators);
      std::optional<BinScenario> result = ReadBinScenario(file, key);
      if (result) {
        state.done += scenario.spec.trials;
        state.done_before += scenario.spec.trials;
      } else {
        result = Measure(scenario, estimators, arguments.threads, progress, state);
        if (!result) break;
        WriteBinScenario(file, *result, key);
      }
      done.push_back(*std::move(result));
    }
  }
  if (!done.empty()) {
    WriteFileAtomically(folder / kBinsFile, BinTableCsv(done));
    const std::string note = arguments.small ? kSmallNote : "";
    const bool has_page = SayIfUnwritten(WritePage(folder / kBinsPage, BinTablePage(done, note)));
    fmt::print("{}{}{} in {}\n", BinTableText(done, note),
               has_page ? fmt::format("{} and ", kBinsPage) : "", kBinsFile, folder.string());
  }
  if (!Interrupted()) return 0;
  fmt::print(stderr,
             "pickbed: stopped after {} of {} scenarios; repeat the same command to continue\n",
             done.size(), scenarios.size());
  return kExitInterrupted;
}

}  // namespace

int BenchmarkBinsCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format("Runs every pose estimator on the same bins and writes {} and {}. Trains the "
                  "models that are missing. After an interrupt, the same command continues.",
                  kBinsFile, kBinsPage),
      "pickbed benchmark bins");
  BinsArguments arguments;
  app.add_option("SCENARIO", arguments.scenarios,
                 "scenarios whose bins are filled [all presets bin_*]");
  app.add_flag(
      "--small", arguments.small,
      fmt::format(
          "small variant: {}, {} bins in all, short training; takes minutes and gives worse poses",
          fmt::join(kSmallScenarios, ", "), kSmallScenes));
  app.add_option("--scenes", arguments.scenes,
                 fmt::format("number of bins per scenario [{}]", kScenes))
      ->check(CLI::Range(1, 100000));
  app.add_option(
         "--estimator", arguments.estimators,
         "rows of the table to compute, separated by semicolons (listed below); default: all")
      ->delimiter(';');
  app.add_option("--catalog", arguments.catalog, "folder with your own objects")
      ->capture_default_str();
  AddThreadsArgument(app, arguments.threads);
  app.add_option("--out", arguments.out, "results folder [results/benchmark-bins]");
  std::string rows;
  for (const BinMethod& method : BinMethods()) rows += fmt::format("  {}\n", method.label);
  app.footer("Rows of the table:\n" + rows +
             "\nExample: pickbed benchmark bins --small\n"
             "         pickbed benchmark bins bin_gear bin_mug --scenes 5 --estimator "
             "'kehl;descriptor:accurate'");
  if (!ParseArguments(app, argc, argv)) return 0;
  return RunBins(arguments);
}

}  // namespace pickbed::eval
