#include <fmt/format.h>

#include "eval/bop/estimate.h"
#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/progress.h"
#include "eval/summary.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

std::vector<TrialResult> LookAtBins(const LoadedScenario& scenario,
                                    const std::filesystem::path& folder) {
  ProgressLine progress;
  TrialRunner runner(scenario.spec, scenario.objects, [&](std::string_view what, double share) {
    progress.Show(fmt::format("{}: {:.0f} %", what, 100 * share));
  });
  std::vector<TrialResult> looks;
  const double start_s = progress.elapsed_s();  // code books are made by now
  const int trials = scenario.spec.trials;
  for (int trial = 0; trial < trials; ++trial) {
    looks.push_back(runner.Look(trial, folder / "pictures" / fmt::format("trial_{:04}", trial)));
    const double a_bin_s = (progress.elapsed_s() - start_s) / (trial + 1);
    progress.Show(fmt::format("bin {}/{}  left {}", trial + 1, trials,
                              FormatDuration(a_bin_s * (trials - trial - 1))));
  }
  return looks;
}

std::string HypothesesCsv(const std::vector<TrialResult>& looks, const ObjectSet& objects) {
  std::string csv =
      "trial,hypothesis,object,instance,score,mssd_m,mssd_diameters,mspd_px,add_m,adi_m,"
      "rotation_rad,translation_m,correct\n";
  for (const TrialResult& look : looks) {
    for (const PickRecord& record : look.picks) {
      for (size_t i = 0; i < record.hypotheses.size(); ++i) {
        const HypothesisScore& h = record.hypotheses[i];
        csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", look.trial, i,
                           objects[h.object]->name, h.instance, h.score, h.mssd_m, h.mssd_diameters,
                           h.mspd_px, h.add_m, h.adi_m, h.rotation_rad, h.translation_m,
                           h.correct ? 1 : 0);
      }
    }
  }
  return csv;
}

std::string EstimateTable(const RunSummary& summary, const std::vector<TrialResult>& looks) {
  int hypotheses = 0, correct = 0;
  for (const TrialResult& look : looks) {
    for (const PickRecord& record : look.picks) {
      for (const HypothesisScore& score : record.hypotheses) {
        ++hypotheses;
        correct += score.correct;
      }
    }
  }
  std::string text = "Recall by visible fraction (MSSD < 0.1 diameter)\n";
  for (const RecallBand& band : summary.recall_by_visibility) {
    if (band.instances == 0) continue;
    text += fmt::format("  {:>3.0f} - {:>3.0f} %   {:>5.1f} %   {} of {}\n", 100 * band.visible_min,
                        100 * band.visible_max, 100.0 * band.recalled / band.instances,
                        band.recalled, band.instances);
  }
  text += fmt::format("hypotheses right     {} of {}\n", correct, hypotheses);
  text += fmt::format("top-ranked right     {} of {} bins\n", summary.top1_correct, summary.frames);
  const auto seconds = summary.seconds.find("estimate");
  if (seconds != summary.seconds.end()) {
    text += fmt::format("seconds a bin        {:.2f}\n", seconds->second);
  }
  return text;
}

// Settings of a scenario that mean something on images that exist: estimator, refiner and seed.
int EstimateBop(const std::string& path, const std::string& split,
                const ScenarioArguments& arguments, const std::string& out) {
  CheckInput(arguments.scenario.empty() && !arguments.trials,
             "--bop takes the place of SCENARIO and --trials; name one or the other");
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
        path, split, {spec.estimator, spec.refiner, spec.seed},
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
      "Fills bins, guesses poses and scores them against the truth, without picking. With --bop, "
      "guesses poses in the images of a BOP data set and writes them as BOP's results CSV.",
      "pickbed estimate");
  ScenarioArguments arguments;
  std::string out, bop_path, split = "test";
  AddScenarioArguments(app, arguments);
  app.get_option("SCENARIO")->required(false);
  auto* bop_option = app.add_option("--bop", bop_path, "a BOP data set, instead of SCENARIO");
  app.add_option("--split", split, "of the BOP data set")->capture_default_str()->needs(bop_option);
  AddTrialsArgument(app, arguments);
  AddOutArgument(app, out, "-estimate");
  app.footer(
      "Example: pickbed estimate demo --trials 5 --set estimator.mode=hard\n"
      "         pickbed estimate --bop bop/ycbv --set estimator.name=ppf");
  if (!ParseArguments(app, argc, argv)) return 0;
  if (!bop_path.empty()) return EstimateBop(bop_path, split, arguments, out);
  CheckInput(!arguments.scenario.empty(),
             "SCENARIO is required (or --bop PATH); see pickbed estimate --help");

  const LoadedScenario scenario = LoadScenarioArguments(arguments);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-estimate");
  MakeFolder(folder);
  const std::vector<TrialResult> looks = LookAtBins(scenario, folder);
  WriteFileAtomically(folder / "hypotheses.csv", HypothesesCsv(looks, scenario.objects));
  fmt::print("{}hypotheses.csv and overlays in {}\n", EstimateTable(Summarize(looks), looks),
             folder.string());
  return 0;
}

}  // namespace pickbed
