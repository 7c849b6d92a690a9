// Commands on BOP results files: their scores, and the picks that follow from them.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "eval/bop/dataset_scores.h"
#include "eval/bop/layout.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/execution/execution.h"
#include "eval/execution/report.h"
#include "eval/replay/replay.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

std::string ScoreTable(const DatasetScores& scores) {
  if (scores.wanted == 0 && scores.detect_wanted == 0) {
    return fmt::format(
        "no image of the split has a target instance, so there is nothing to score; the results "
        "have {} of objects that their image does not have\n",
        Counted(static_cast<size_t>(scores.estimates_of_absent), "estimate"));
  }
  std::string text = fmt::format(
      "BOP19, 6D localisation: {} in {}\n  AR         {:.3f}\n  AR VSD     "
      "{:.3f}\n  AR MSSD    {:.3f}\n  AR MSPD    {:.3f}\n  ADI        {:.3f}  share with ADI < 0.1 "
      "diameter\nBOP24, 6D detection\n  AP         {:.3f}\n  AP MSSD    {:.3f}\n  AP MSPD    "
      "{:.3f}\nBOP25, 6D detection\n  AP         {:.3f}  MSSD, 0.05 to 0.5 diameters\n  AP mm      "
      "{:.3f}  MSSD, 2 to 20 mm\n",
      Counted(scores.wanted, "target instance"), Counted(scores.images, "image"), scores.ar(),
      scores.ar_vsd, scores.ar_mssd, scores.ar_mspd, scores.adi_recall, scores.ap(), scores.ap_mssd,
      scores.ap_mspd, scores.ap_mssd, scores.ap_mssd_mm);
  text += "object  targets  AR VSD  AR MSSD  AR MSPD    ADI  AP MSSD  AP MSPD\n";
  for (const auto& [id, object] : scores.objects) {
    text += fmt::format("{:>6}  {:>7}  {:>6.3f}  {:>7.3f}  {:>7.3f}  {:>5.3f}", id, object.wanted,
                        object.ar_vsd, object.ar_mssd, object.ar_mspd, object.adi_recall);
    text += object.detectable
                ? fmt::format("  {:>7.3f}  {:>7.3f}\n", object.ap_mssd, object.ap_mspd)
                : "        -        -\n";
  }
  text += fmt::format(
      "never reported: {} of {} instances have no estimate within half a diameter\nvisible at "
      "least  instances  right, %  AR MSSD\n",
      scores.never_reported, scores.detect_wanted);
  for (const FloorRecall& floor : scores.floors) {
    text += fmt::format(
        "{:>16}  {:>9}  {:>8}  {:>7.3f}\n", WholePercentText(floor.visible_min), floor.instances,
        PercentNumber(Recall{floor.correct, floor.instances}.value()), floor.average_recall);
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
  if (scores.estimates_of_absent > 0) {
    text += fmt::format(
        "{} estimates are of objects that their image does not have; AP does not count them, as in "
        "the BOP toolkit\n",
        scores.estimates_of_absent);
  }
  for (const std::string& note : scores.notes) text += note + "\n";
  return text;
}

// All values with all digits. Values that the BOP toolkit has too have its names.
std::string ScoresJson(const DatasetScores& scores) {
  nlohmann::ordered_json json{{"bop19_average_recall_vsd", scores.ar_vsd},
                              {"bop19_average_recall_mssd", scores.ar_mssd},
                              {"bop19_average_recall_mspd", scores.ar_mspd},
                              {"bop19_average_recall", scores.ar()},
                              {"bop24_mAP_mssd", scores.ap_mssd},
                              {"bop24_mAP_mspd", scores.ap_mspd},
                              {"bop24_mAP", scores.ap()},
                              {"bop25_mAP", scores.ap_mssd},
                              {"bop25_mAP_mm", scores.ap_mssd_mm},
                              {"adi_recall", scores.adi_recall},
                              {"instances", scores.detect_wanted},
                              {"never_reported", scores.never_reported},
                              {"estimates_of_absent_objects", scores.estimates_of_absent}};
  json["recall_by_visibility"] = nlohmann::ordered_json::array();
  for (const FloorRecall& floor : scores.floors) {
    json["recall_by_visibility"].push_back(
        {{"visible_min", floor.visible_min},
         {"instances", floor.instances},
         {"right", Recall{floor.correct, floor.instances}.value()},
         {"average_recall_mssd", floor.average_recall}});
  }
  return json.dump(2) + "\n";
}

struct ExecuteArguments {
  ExecutionOptions options;
  std::string dataset, out, catalog = "objects";
  std::vector<std::string> results, grippers, settings;
  bool programs = false;
};

// Loads the scenario of the stored scenes with the settings of the command line.
LoadedScenario ScenarioOf(const ExecuteArguments& arguments) {
  const std::filesystem::path file = arguments.options.dataset / kDatasetScenarioFile;
  CheckInput(std::filesystem::exists(file),
             fmt::format("{}: is missing, so the dataset has no stored scenes to pick in; make one "
                         "with `pickbed dataset make` or `pickbed run --bop-out`",
                         file.string()));
  ScenarioRequest request{file.string(), {}, arguments.catalog, {}};
  for (const std::string& setting : arguments.settings) {
    CheckInput(setting.starts_with("planner.") || setting.starts_with("policy."),
               fmt::format("--set {}: the scenes are fixed, so only planner.* and policy.* can "
                           "be set",
                           setting));
    request.settings.push_back(setting);
  }
  if (!arguments.grippers.empty()) {
    request.settings.push_back(fmt::format("gripper=[{}]", fmt::join(arguments.grippers, ", ")));
  }
  LoadedScenario loaded = FindScenario(request);
  // Only the planner is used. A program of the command line is the user's own.
  const bool is_own = std::ranges::any_of(arguments.settings, [](const std::string& setting) {
    return setting.starts_with("planner.command=") || setting.starts_with("planner.connect=");
  });
  ScenarioSpec used;
  used.planner = loaded.spec.planner;
  RequireProgramsAllowed(used, file.string(), arguments.programs || is_own);
  return loaded;
}

ExecutionReport ExecuteWithProgress(const LoadedScenario& scenario,
                                    const ExecutionOptions& options) {
  ProgressLine progress;
  ExecutionListener listener;
  listener.on_image = [&](const ExecutionProgress& state) {
    ProgressState shown;
    shown.what = "image";
    shown.done = state.done;
    shown.total = state.total;
    shown.done_before = state.done_before;
    shown.counts_successes = true;
    shown.outcomes = state.outcomes;
    progress.Show(shown);
  };
  listener.on_warning = [&](const std::string& line) { progress.Note(line); };
  listener.stop = Interrupted;
  return ExecuteResults(scenario.spec, scenario.objects, options, listener);
}

int Execute(ExecuteArguments arguments) {
  CatchInterrupts();
  ExecutionOptions& options = arguments.options;
  options.dataset = arguments.dataset;
  options.results.assign(arguments.results.begin(), arguments.results.end());
  const LoadedScenario scenario = ScenarioOf(arguments);
  const std::string name =
      std::filesystem::absolute(options.dataset / "x").lexically_normal().parent_path().filename();
  options.out = OutFolder(arguments.out, name, "-execute");
  const ExecutionReport report = ExecuteWithProgress(scenario, options);
  if (report.interrupted) {
    fmt::print(stderr, "pickbed: stopped; repeat the same command with --resume to continue\n");
    return kExitInterrupted;
  }
  if (!report.lost.empty()) {
    throw std::runtime_error(fmt::format("{} images failed, the first: {}; --resume repeats them",
                                         report.lost.size(), report.lost.front().why));
  }
  const ExecutionStatistics statistics = StatisticsOf(report.methods, report.picks);
  WriteFileAtomically(options.out / kExecutionSummaryFile, ExecutionJson(statistics));
  const std::string what =
      fmt::format("Data set {}, gripper {}", name, scenario.spec.gripper.InWords());
  const bool has_page =
      SayIfUnwritten(WritePage(options.out / kReportFile, ExecutionPage(statistics, what)));
  fmt::print("{}results in {}{}\n", ExecutionText(statistics), options.out.string(),
             has_page ? fmt::format(", page: {}", (options.out / kReportFile).string()) : "");
  return 0;
}

}  // namespace

int ScoreCommand(int argc, char** argv) {
  CLI::App app(
      "Scores pose estimates on a BOP dataset: VSD, MSSD, MSPD and AR as in BOP19, AP as in "
      "BOP24 and BOP25.",
      "pickbed score");
  std::string path, csv, split = "test";
  std::vector<std::string> tolerances;
  ScoreOptions options;
  bool json = false;
  double delta_mm = 1e3 * options.vsd.delta_m;
  app.add_option("--bop", path, "folder of the dataset")->required();
  app.add_option("RESULTS", csv, "results file in BOP format: scene_id,im_id,obj_id,score,R,t,time")
      ->required();
  app.add_option("--split", split, "scene folder of the dataset")->capture_default_str();
  app.add_option("--vsd-delta", delta_mm,
                 "VSD: distance behind the measured depth up to which a pixel counts as visible, "
                 "mm; BOP uses 5 for itodd")
      ->check(WithoutUpperLimit(/*from_zero=*/false))
      ->capture_default_str();
  app.add_option(
         "--tolerance", tolerances,
         "ID=PLACE, separated by commas: an obj_id and the folder of its map from `pickbed "
         "tolerance`; prints the mean predicted probability that a pick at an estimate succeeds")
      ->delimiter(',');
  app.add_option("--max-estimates", options.max_estimates,
                 "number of estimates of an image that count in AP, those with the highest scores "
                 "[100; 200 for xyzibd]")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--camera", options.sensor,
                 "camera of a dataset with several: CAM of scene_gt_CAM.json");
  app.add_flag("--json", json, "print all values as JSON on stdout, and nothing else");
  app.footer("Example: pickbed score --bop bop/ycbv results/ppf_ycbv-test.csv");
  if (!ParseArguments(app, argc, argv)) return 0;
  options.vsd.delta_m = 1e-3 * delta_mm;
  const bool is_xyzibd = csv.find("_xyzibd-") != std::string::npos;
  if (options.max_estimates == 0 && is_xyzibd) options.max_estimates = kMaxEstimatesOfXyzibd;
  const TolerancesById models = ReadTolerances(tolerances);
  const std::vector<DatasetEstimate> estimates = ReadEstimates(csv);
  DatasetScores scores;
  {
    ProgressLine progress;
    scores = EvaluateDataset(path, split, estimates, options, models,
                             [&](const std::string& scene) { progress.Show("scoring " + scene); });
  }
  fmt::print("{}", json ? ScoresJson(scores) : ScoreTable(scores));
  return 0;
}

int ExecuteCommand(int argc, char** argv) {
  CLI::App app(
      "Executes the picks that follow from BOP results files, in the scenes that the images of a "
      "pickbed dataset show. Compares the methods, and measures how well BOP's errors predict the "
      "outcome of a pick.",
      "pickbed execute");
  ExecuteArguments arguments;
  ExecutionOptions& options = arguments.options;
  app.add_option("--dataset", arguments.dataset,
                 "folder of a dataset with stored scenes, from `pickbed dataset make` or `pickbed "
                 "run --bop-out`")
      ->required();
  app.add_option("RESULTS", arguments.results,
                 "results files in BOP format, one per method; scores of any scale, only their "
                 "order counts");
  app.add_flag("--oracle", options.oracle, "also execute the true poses, as the method oracle");
  app.add_option("--gripper", arguments.grippers,
                 "gripper, or several separated by commas [as in the scenario of the dataset]")
      ->delimiter(',');
  app.add_option("--picks", options.picks, "maximum number of picks per image and method")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--split", options.split, "scene folder of the dataset")->capture_default_str();
  app.add_option("--set", arguments.settings,
                 "KEY=VALUE: a setting of planner or policy, for example policy.success=held");
  app.add_option("--catalog", arguments.catalog, "folder with your own objects")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "folder of the results [results/<dataset>-execute]");
  AddJobsArgument(app, options.jobs);
  app.add_flag("--resume", options.resume, "continue an interrupted execution");
  AddProgramsArgument(app, arguments.programs);
  app.footer("Example: pickbed execute --dataset bop/demo a.csv b.csv --gripper jaw_8cm");
  if (!ParseArguments(app, argc, argv)) return 0;
  return Execute(std::move(arguments));
}

}  // namespace pickbed::eval
