#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "eval/bop/estimate.h"
#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/comparison_report.h"
#include "eval/interrupt.h"
#include "eval/progress.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr int kPicturedBins = 5;

std::vector<ComparedRow> LookAtBins(const ComparisonJob& job) {
  ProgressLine progress;
  double start_s = 0;
  ComparisonJob shown = job;
  shown.stop = Interrupted;
  shown.on_progress = [&](std::string_view what, int done, int total) {
    if (what != "bin") {
      progress.Show(fmt::format("{}: {} %", what, done));
      start_s = progress.elapsed_s();
      return;
    }
    const double a_bin_s = (progress.elapsed_s() - start_s) / done;
    progress.Show(
        fmt::format("bin {}/{}  left {}", done, total, FormatDuration(a_bin_s * (total - done))));
  };
  return CompareEstimators(shown);
}

// Overlays of the first bins, as seen from the page.
std::vector<std::string> Overlays(const std::filesystem::path& folder) {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::filesystem::path& path = entry.path();
    if (path.filename() != "pick_00_overlay.png") continue;
    found.push_back(path.lexically_relative(folder).string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

int EstimateScenario(const ScenarioArguments& arguments, const std::vector<std::string>& estimators,
                     const std::string& out, int threads) {
  const LoadedScenario scenario = LoadScenarioArguments(arguments);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-estimate");
  MakeFolder(folder / "pictures");
  const std::vector<std::string> labels =
      estimators.empty() ? std::vector{scenario.spec.estimator.name} : estimators;
  CatchInterrupts();
  const ComparisonJob job{scenario.spec,
                          scenario.objects,
                          ParseEstimators(labels, scenario.spec.estimator),
                          folder / "pictures",
                          kPicturedBins,
                          threads,
                          {},
                          {}};
  const std::vector<ComparedRow> rows = LookAtBins(job);
  WriteFileAtomically(folder / "hypotheses.csv", HypothesesCsv(rows, scenario.objects));
  WriteFileAtomically(folder / "comparison.csv", ComparisonCsv(rows, scenario.objects));
  WriteFileAtomically(
      folder / "comparison.html",
      ComparisonPage("Poses in bins: " + scenario.name, rows, scenario.objects, Overlays(folder)));
  fmt::print("{}comparison.html, comparison.csv, hypotheses.csv and overlays in {}\n",
             ComparisonTable(rows), folder.string());
  if (!Interrupted()) return 0;
  fmt::print(stderr, "pickbed: interrupted after {} of {} bins\n", rows.front().looks.size(),
             scenario.spec.trials);
  return kExitInterrupted;
}

// Settings of a scenario that mean something on images that exist: estimator, refiner and seed.
int EstimateBop(const std::string& path, const std::string& split,
                const ScenarioArguments& arguments, const std::string& out, int threads) {
  CheckInput(arguments.scenario.empty() && !arguments.trials,
             "--bop takes the place of SCENARIO and --trials; name one or the other");
  CheckInput(std::filesystem::is_directory(path),
             fmt::format("--bop {}: is no folder; name one with models/ and {}/", path, split));
  ScenarioSpec spec;
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { spec.Visit(v); });
  }
  const std::string data_set =
      (std::filesystem::absolute(path) / ".").lexically_normal().parent_path().filename().string();
  const std::filesystem::path folder = OutFolder(out, data_set, "-estimate");
  MakeFolder(folder);
  std::vector<bop::Estimate> estimates;
  {
    ProgressLine progress;
    estimates = bop::EstimateDataset(
        path, split, {spec.estimator, spec.refiner, spec.seed, threads},
        [&](const bop::EstimateProgress& state) {
          progress.Show(fmt::format("{}: {:.0f} %", state.what, 100 * state.share));
        });
  }
  const std::filesystem::path csv =
      folder / fmt::format("{}_{}-{}.csv", spec.estimator.name, data_set, split);
  WriteFileAtomically(csv, bop::WriteResults(estimates));
  fmt::print("{} estimates in {}\nscore them with pickbed score --bop {} --split {} {}\n",
             estimates.size(), csv.string(), path, split, csv.string());
  return 0;
}

}  // namespace

int EstimateCommand(int argc, char** argv) {
  CLI::App app(
      "Fills bins, guesses poses and scores them against the truth, without picking; compares "
      "several estimators on the same bins. With --bop, "
      "guesses poses in the images of a BOP data set and writes them as BOP's results CSV.",
      "pickbed estimate");
  ScenarioArguments arguments;
  std::vector<std::string> estimators;
  std::string out, bop_path, split = "test";
  AddScenarioArguments(app, arguments);
  app.get_option("SCENARIO")->required(false);
  auto* bop_option = app.add_option("--bop", bop_path, "a BOP data set, instead of SCENARIO");
  app.add_option("--split", split, "of the BOP data set")->capture_default_str()->needs(bop_option);
  app.add_option("--estimator", estimators,
                 "one or several, each NAME or NAME:MODE, to compare on the same bins")
      ->delimiter(',');
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  app.add_option("--threads", threads, "at most; results do not depend on it")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  AddTrialsArgument(app, arguments);
  AddOutArgument(app, out, "-estimate");
  app.footer(
      "Example: pickbed estimate bin_rod --trials 20 --estimator descriptor:hard,ppf\n"
      "         pickbed estimate --bop bop/ycbv --set estimator.name=ppf");
  if (!ParseArguments(app, argc, argv)) return 0;
  if (!bop_path.empty()) return EstimateBop(bop_path, split, arguments, out, threads);
  CheckInput(!arguments.scenario.empty(),
             "SCENARIO is required (or --bop PATH); see pickbed estimate --help");
  return EstimateScenario(arguments, estimators, out, threads);
}

}  // namespace pickbed
