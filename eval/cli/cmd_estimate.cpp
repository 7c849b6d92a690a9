#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <optional>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/image/cmd_estimate_bop.h"
#include "eval/cli/image/cmd_estimate_image.h"
#include "eval/cli/image/estimate_arguments.h"
#include "eval/estimate/image_poses.h"
#include "eval/estimate/report.h"
#include "eval/explain/explain.h"
#include "eval/frames/image_estimator.h"
#include "eval/report/completed_shapes.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "eval/tolerance/maps.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/ids_format.h"

namespace pickbed::eval {
namespace {

constexpr int kPicturedBins = 5;

std::vector<ComparedRow> EstimateBins(const ComparisonJob& job) {
  ProgressLine progress;
  ComparisonJob shown = job;
  shown.stop = Interrupted;
  shown.on_warning = [&](const std::string& line) { progress.Note(line); };
  shown.on_progress = [&](std::string_view what, int done, int total) {
    if (what != "bin") {
      progress.Show(fmt::format("{}: {} %", what, done));
      progress.Restart();
      return;
    }
    ProgressState state;
    state.what = "bin";
    state.done = done;
    state.total = total;
    progress.Show(state);
  };
  return CompareEstimators(shown);
}

// Returns the overlays of the first bins, relative to the page. Overlays older than `start` are
// from an earlier run in the same folder and are left out.
std::vector<std::string> Overlays(const std::filesystem::path& folder,
                                  std::filesystem::file_time_type start) {
  std::vector<std::string> found;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder / kPicturesFolder)) {
    const std::filesystem::path& path = entry.path();
    if (path.filename() != AttemptPicture(0, "overlay") || entry.last_write_time() < start)
      continue;
    found.push_back(path.lexically_relative(folder).string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

int EstimateScenario(const ScenarioRequest& arguments, const std::vector<std::string>& estimators,
                     const std::vector<std::string>& tolerance, const std::string& out,
                     int threads) {
  const LoadedScenario scenario = FindScenario(arguments);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-estimate");
  const std::vector<ComparedEstimator> compared =
      NamedEstimators(arguments, estimators, scenario.spec.estimator);
  RequireModes(scenario.spec, compared);
  const ToleranceMaps maps = MapsFor(scenario.spec, scenario.objects, tolerance);
  MakeFolder(folder / kPicturesFolder);
  constexpr std::chrono::seconds kClockSlack{1};  // resolution of file times
  const auto start = std::filesystem::file_time_type::clock::now() - kClockSlack;
  CatchInterrupts();
  const ComparisonJob job{scenario.spec, scenario.objects, compared, folder,
                          kPicturedBins, threads,          {},       {}};
  std::vector<ComparedRow> rows;
  try {
    rows = EstimateBins(job);
  } catch (const InputError& error) {
    throw WithTrainingHint(error, arguments.scenario, scenario.spec);
  }
  if (!maps.empty()) AddPickChances(maps, rows);
  WriteFileAtomically(folder / kHypothesesFile, HypothesesCsv(rows, scenario.objects));
  WriteFileAtomically(folder / kInstancesFile, InstancesCsv(rows, scenario.objects));
  WriteFileAtomically(folder / kComparisonFile, ComparisonCsv(rows, scenario.objects));
  const bool has_page = SayIfUnwritten(WritePage(
      folder / kComparisonPage, ComparisonPage("Poses in bins: " + scenario.name, rows,
                                               scenario.objects, Overlays(folder, start))));
  fmt::print("{}{}{}, {}, {} and overlays in {}\n", ComparisonTable(rows),
             has_page ? fmt::format("{}, ", kComparisonPage) : "", kComparisonFile, kHypothesesFile,
             kInstancesFile, folder.string());
  if (!Interrupted()) return 0;
  fmt::print(stderr, "pickbed: interrupted after {} of {} bins\n", rows.front().images.size(),
             scenario.spec.trials);
  return kExitInterrupted;
}

// Parses the trial number of --explain.
BinIndex ExplainedBin(const std::string& image) {
  int trial = -1;
  const auto [end, error] = std::from_chars(image.data(), image.data() + image.size(), trial);
  CheckInput(
      error == std::errc() && end == image.data() + image.size() && trial >= 0,
      fmt::format("--explain {}: with a SCENARIO, give the number of a trial, from 0", image));
  return BinIndex(trial);
}

int ExplainScenario(const ScenarioRequest& arguments, const std::vector<std::string>& estimators,
                    const std::string& image, const std::string& out) {
  CheckInput(!arguments.trials, "--explain shows one image; remove --trials");
  const BinIndex bin_index = ExplainedBin(image);
  LoadedScenario scenario = FindScenario(arguments);
  if (CompletesShapes(scenario.spec.planner.name)) {
    CheckInput(estimators.empty(), fmt::format("planner {} needs no poses; remove --estimator, or "
                                               "set planner.name to explain an estimator",
                                               scenario.spec.planner.name));
    SayWhereExplained(
        ExplainUnknown(scenario.spec, scenario.objects,
                       fmt::format("Planner {} on {}, trial {}", scenario.spec.planner.name,
                                   scenario.name, bin_index),
                       bin_index, OutFolder(out, scenario.name, "-explain")));
    return 0;
  }
  scenario.spec.estimator = ExplainedEstimator(arguments, estimators, scenario.spec.estimator);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-explain");
  ExplanationPage page;
  try {
    ProgressLine progress;
    page = ExplainTrial(
        scenario.spec, scenario.objects,
        fmt::format("{} on {}, trial {}", scenario.spec.estimator.name, scenario.name, bin_index),
        bin_index, folder, [&](std::string_view what, double share) {
          progress.Show(fmt::format("{}: {}", what, WholePercentText(share)));
        });
  } catch (const InputError& error) {
    throw WithTrainingHint(error, arguments.scenario, scenario.spec);
  }
  SayWhereExplained(page);
  return 0;
}

}  // namespace

int EstimateCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format(
          "Fills bins, estimates poses and scores them against ground truth, without picking. "
          "Compares several estimators on the same bins. With --bop, estimates poses in the images "
          "of a BOP dataset and writes them as a BOP results file, beside a list of the images. "
          "With an image, estimates poses in it and writes {}, {} and {}.",
          kOverlayFile, kPosesJsonFile, kPosesCsvFile),
      "pickbed estimate");
  ScenarioRequest arguments;
  std::vector<std::string> estimators, tolerance;
  BopArguments bop;
  ImageArguments image;
  std::string out, explained;
  AddScenarioArguments(app, arguments);
  app.get_option("SCENARIO")
      ->required(false)
      ->description(
          "scenario file, name of a preset (see pickbed list presets), or an image: a color image "
          "with --depth, a depth image or an organised cloud");
  AddBopArguments(app, bop);
  app.add_option("--roi", bop.roi,
                 "region of interest of --bop and IMAGE: auto, world:X,Y,Z,X,Y,Z or "
                 "camera:X,Y,Z,X,Y,Z (two corners of a box, m), or a mask image; a SCENARIO has "
                 "the setting roi");
  AddImageArguments(app, image);
  app.add_option("--estimator", estimators,
                 "one or several estimators to compare on the same bins, separated by commas; each "
                 "is NAME, NAME:MODE, NAME=MODEL or NAME:MODE=MODEL, where MODEL is a file trained "
                 "for this estimator")
      ->delimiter(',');
  int threads = 1;
  AddThreadsArgument(app, threads);
  app.add_option(
      "--explain", explained,
      "write a page with each stage of the estimate for one image instead of scores: number of a "
      "trial, or SCENE/IMAGE with --bop; with a planner that completes shapes, the page shows "
      "segments, completed shapes and the first pick; results folder is results/NAME-explain, with "
      "--bop "
      "results/NAME-bop-explain");
  AddTrialsArgument(app, arguments);
  AddToleranceArgument(app, tolerance);
  AddOutArgument(app, out, "-estimate");
  app.footer(
      "Example: pickbed estimate bin_rod --trials 20 --estimator "
      "descriptor:accurate,ppf,kehl=kehl.net\n"
      "         pickbed estimate bin_rod --explain 3\n"
      "         pickbed estimate --bop bop/ycbv --set estimator.name=ppf\n"
      "         pickbed estimate color.png --depth depth.png --intrinsics 615,615,320,240 --mesh "
      "cup.ply --estimator ppf");
  if (!ParseArguments(app, argc, argv)) return 0;
  const bool explain = app.count("--explain") > 0;
  CheckInput(tolerance.empty() || (bop.path.empty() && !explain),
             "--tolerance applies to poses of a SCENARIO; with --bop, pass it to pickbed score");
  if (!bop.path.empty()) {
    return explain ? ExplainBop(bop, arguments, estimators, explained, out)
                   : EstimateBop(bop, arguments, estimators, out, threads);
  }
  CheckInput(!arguments.scenario.empty(),
             "give a SCENARIO, an image or --bop PATH; see pickbed estimate --help");
  if (IsImage(arguments, image)) {
    CheckInput(!explain && estimators.size() < 2 && tolerance.empty(),
               "an image takes one --estimator and neither --explain nor --tolerance");
    const ScenarioSpec settings = ImageSettings(arguments, kMinImageScore);
    const EstimatorSpec estimator =
        NamedEstimators(arguments, estimators, settings.estimator).front().spec;
    return EstimateImage(arguments, image, estimator, settings, bop.roi, out, threads);
  }
  CheckInput(bop.roi.empty(), "--roi applies to --bop and images; a SCENARIO has the setting roi");
  CheckInput(image.intrinsics.empty() && image.objects.empty() && image.depth_scale_mm == 0,
             "--intrinsics, --object and --depth-scale apply to an image; give one");
  if (explain) return ExplainScenario(arguments, estimators, explained, out);
  return EstimateScenario(arguments, estimators, tolerance, out, threads);
}

}  // namespace pickbed::eval
