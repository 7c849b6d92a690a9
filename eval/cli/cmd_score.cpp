#include <fmt/format.h>

#include "eval/bop/dataset_scores.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/runtime/progress.h"

namespace pickbed::eval {
namespace {

std::string ScoreTable(const DatasetScores& scores) {
  std::string text = fmt::format(
      "BOP19, 6D localisation: {} target instances in {} images\n  AR         {:.3f}\n  AR VSD     "
      "{:.3f}\n  AR MSSD    {:.3f}\n  AR MSPD    {:.3f}\n  ADI        {:.3f}  share with ADI < 0.1 "
      "diameter\nBOP24, 6D detection\n  AP         {:.3f}\n  AP MSSD    {:.3f}\n  AP MSPD    "
      "{:.3f}\n",
      scores.wanted, scores.images, scores.ar(), scores.ar_vsd, scores.ar_mssd, scores.ar_mspd,
      scores.adi_recall, scores.ap(), scores.ap_mssd, scores.ap_mspd);
  text += "object  targets  AR VSD  AR MSSD  AR MSPD    ADI  AP MSSD  AP MSPD\n";
  for (const auto& [id, object] : scores.objects) {
    text += fmt::format("{:>6}  {:>7}  {:>6.3f}  {:>7.3f}  {:>7.3f}  {:>5.3f}", id, object.wanted,
                        object.ar_vsd, object.ar_mssd, object.ar_mspd, object.adi_recall);
    text += object.detectable
                ? fmt::format("  {:>7.3f}  {:>7.3f}\n", object.ap_mssd, object.ap_mspd)
                : "        -        -\n";
  }
  for (const auto& [id, object] : scores.objects) {
    if (!object.pick_chance) continue;
    text += fmt::format(
        "object {}: mean predicted probability that a pick at the estimate of a target instance "
        "succeeds: {:.3f}\n",
        id, *object.pick_chance);
  }
  if (scores.seconds_an_image >= 0) {
    text += fmt::format("seconds per image  {:.2f}\n", scores.seconds_an_image);
  }
  if (scores.estimates_elsewhere > 0) {
    text += fmt::format("{} estimates are for images that are no target and do not count\n",
                        scores.estimates_elsewhere);
  }
  for (const std::string& note : scores.notes) text += note + "\n";
  return text;
}

}  // namespace

int ScoreCommand(int argc, char** argv) {
  CLI::App app(
      "Scores pose estimates on a BOP dataset: VSD, MSSD, MSPD and AR as in BOP19, AP as in BOP24.",
      "pickbed score");
  std::string path, csv, split = "test";
  std::vector<std::string> tolerances;
  VsdOptions vsd;
  double delta_mm = 1e3 * vsd.delta_m;
  app.add_option("--bop", path, "folder of the dataset")->required();
  app.add_option("RESULTS", csv, "results file in BOP format: scene_id,im_id,obj_id,score,R,t,time")
      ->required();
  app.add_option("--split", split, "scene folder of the dataset")->capture_default_str();
  app.add_option("--vsd-delta", delta_mm,
                 "VSD: distance behind the measured depth up to which a pixel counts as visible, "
                 "mm; BOP uses 5 for itodd")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option(
         "--tolerance", tolerances,
         "ID=PLACE, separated by commas: an obj_id and the folder of its map from `pickbed "
         "tolerance`; prints the mean predicted probability that a pick at an estimate succeeds")
      ->delimiter(',');
  app.footer("Example: pickbed score --bop bop/ycbv results/ppf_ycbv-test.csv");
  if (!ParseArguments(app, argc, argv)) return 0;
  vsd.delta_m = 1e-3 * delta_mm;
  const TolerancesById models = ReadTolerances(tolerances);
  const std::vector<DatasetEstimate> estimates = ReadEstimates(csv);
  DatasetScores scores;
  {
    ProgressLine progress;
    scores = EvaluateDataset(path, split, estimates, vsd, models,
                             [&](const std::string& scene) { progress.Show("scoring " + scene); });
  }
  fmt::print("{}", ScoreTable(scores));
  return 0;
}

}  // namespace pickbed::eval
