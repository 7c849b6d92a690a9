#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/run_progress.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/segments/segmentation.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

std::string MethodHelp() {
  std::string help = "method, may be repeated; default: all.";
  for (const auto& row : perception::SegmenterTable()) {
    help += fmt::format(" {}: {}.", row.name, row.help);
  }
  return help;
}

}  // namespace

int SegmentCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format("Divides depth images into unknown objects, without any object model, and scores "
                  "the segments against the labels. The images are the first ones of the bins of a "
                  "scenario, or labelled clouds. Writes {}, {} and overlay pictures.",
                  kSegmentScoresFile, kSegmentsFile),
      "pickbed segment");
  ScenarioRequest arguments;
  SegmentationOptions options;
  std::string out, clouds;
  bool json = false;
  AddScenarioArguments(app, arguments);
  app.get_option("SCENARIO")->required(false);
  AddTrialsArgument(app, arguments);
  app.add_option("--clouds", clouds,
                 "folder of organised clouds (*.pcd with x, y, z and label) instead of a scenario");
  app.add_option("--background-label", options.background_label,
                 "labels of a cloud up to this one are background")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option("--method", options.methods, MethodHelp());
  app.add_option("--pictures", options.pictured_images, "number of images with an overlay picture")
      ->check(WithoutUpperLimit())
      ->capture_default_str();
  app.add_flag("--json", json, "print the table as JSON on stdout, and nothing else");
  AddOutArgument(app, out, "-segments");
  app.footer("Example: pickbed segment clutter --trials 20");
  if (!ParseArguments(app, argc, argv)) return 0;
  CheckInput(clouds.empty() != arguments.scenario.empty(),
             "give either a SCENARIO or --clouds, so that there are images to segment");
  for (const char* of_scenario : {"--set", "--trials", "--catalog"}) {
    CheckInput(clouds.empty() || app.count(of_scenario) == 0,
               fmt::format("{} belongs to a SCENARIO; it does nothing with --clouds", of_scenario));
  }
  CheckInput(!clouds.empty() || app.count("--background-label") == 0,
             "--background-label belongs to --clouds; it does nothing with a SCENARIO");

  CatchInterrupts();
  ProgressLine progress;
  const auto on_image = [&](int done, int total) {
    progress.Show(fmt::format("{} of {} images", done, total));
    return !Interrupted();
  };
  std::vector<SegmentationRow> rows;
  std::filesystem::path folder;
  const auto choose_folder = [&](const std::string& name) {
    folder = OutFolder(out, name, "-segments");
    options.pictures = folder / kPicturesFolder;
  };
  if (clouds.empty()) {
    const LoadedScenario scenario = FindScenario(arguments, ShowObjectsOn(progress));
    choose_folder(scenario.name);
    rows = SegmentBins(scenario.spec, scenario.objects, options, on_image);
  } else {
    choose_folder("clouds");
    rows = SegmentClouds(clouds, options, on_image);
  }
  WriteFileAtomically(folder / kSegmentScoresFile, SegmentScoresCsv(rows));
  WriteFileAtomically(folder / kSegmentsFile, SegmentsCsv(rows));
  if (json) {
    fmt::print("{}", SegmentationJson(rows));
  } else {
    fmt::print("{}{}, {} and overlays in {}\n", SegmentationTable(rows), kSegmentScoresFile,
               kSegmentsFile, folder.string());
  }
  return Interrupted() ? kExitInterrupted : 0;
}

}  // namespace pickbed::eval
