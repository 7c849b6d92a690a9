#include <fmt/format.h>

#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/progress.h"
#include "eval/summary.h"

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

}  // namespace

int EstimateCommand(int argc, char** argv) {
  CLI::App app("Fills bins, guesses poses and scores them against the truth, without picking.",
               "pickbed estimate");
  ScenarioArguments arguments;
  std::string out;
  AddScenarioArguments(app, arguments);
  AddTrialsArgument(app, arguments);
  AddOutArgument(app, out, "-estimate");
  app.footer("Example: pickbed estimate demo --trials 5 --set estimator.mode=hard");
  if (!ParseArguments(app, argc, argv)) return 0;

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
