#include <fmt/format.h>

#include <limits>
#include <memory>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/run_progress.h"
#include "eval/draw/bin_view.h"
#include "eval/export/scene_json.h"
#include "eval/summary/clutter_json.h"
#include "eval/summary/setting_notes.h"
#include "eval/trial/clutter.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

// Returns what plans the grasps that are counted, at true poses, so that no estimator is loaded.
// Null for a planner without poses, which has no such grasps.
std::unique_ptr<TrialSetup> GraspCounter(const LoadedScenario& scenario) {
  if (!NeedsPoses(scenario.spec)) return nullptr;
  TrialOptions options;
  options.truth = {true, true, true, true, false};
  return std::make_unique<TrialSetup>(scenario.spec, scenario.objects, TrialSetup::Progress{},
                                      options);
}

}  // namespace

int DropCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format(
          "Fills one bin, simulates until all objects are at rest, and writes {}, {}, {}, the "
          "image of the camera (color.png) and a picture with materials and shadows for "
          "people ({}).",
          kSceneFile, kCertificateFile, kClutterFile, kPictureFile),
      "pickbed drop");
  ScenarioRequest arguments;
  std::string out;
  int trial = 0;
  AddScenarioArguments(app, arguments);
  AddOutArgument(app, out, "-drop");
  app.add_option("--trial", trial, "number of the trial of the scenario, from 0")
      ->check(WithoutUpperLimit())
      ->capture_default_str();
  app.footer("Example: pickbed drop demo --set objects.0.count=30 --trial 2");
  if (!ParseArguments(app, argc, argv)) return 0;

  const BinIndex bin_index(trial);
  ProgressLine progress;
  const ObjectProgress on_object = ShowObjectsOn(progress);
  const LoadedScenario scenario = FindScenario(arguments, on_object);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-drop");
  // Before the drop: it refuses a gripper that cannot hold the objects.
  const std::unique_ptr<TrialSetup> counter = GraspCounter(scenario);
  fmt::print(stderr, "{}", SmallObjectNote(scenario.spec, scenario.objects));
  MakeFolder(folder);
  SimulatedCell cell(scenario.spec, scenario.objects);
  cell.SetOnPrepare(on_object);
  const CertifiedScene made = cell.MakeScene(bin_index);
  WriteFileAtomically(folder / kSceneFile, SceneJson(made.scene, cell.objects()));
  WritePng(folder / "color.png", cell.ColorPicture(made.scene, bin_index));
  WritePng(folder / kPictureFile,
           cell.PictureOf(made.scene, bin_index, BinCamera(cell.camera(), cell.bin())).color);
  WriteFileAtomically(folder / kCertificateFile, CertificateJson(made));
  const Observation view = cell.Capture(made.scene, bin_index, 0);
  ClutterStatistics statistics = MeasureClutter(cell, made.scene, bin_index, view);
  GraspableCount count;
  if (counter) {
    count = CountGraspable(*counter, made.scene, view.visible_fractions,
                           std::numeric_limits<int>::max());
  }
  statistics.tested = count.tested;
  statistics.graspable = count.graspable;
  const ClutterSummary clutter = ClutterOfBin(statistics);
  WriteFileAtomically(folder / kClutterFile, ClutterJson(clutter, scenario.spec.gripper.InWords()));
  fmt::print("{}{}wrote {}, {}, {}, color.png and {}\n", CertificateText(made),
             ClutterText(clutter, scenario.spec.gripper.InWords()), (folder / kSceneFile).string(),
             kCertificateFile, kClutterFile, kPictureFile);
  return 0;
}

}  // namespace pickbed::eval
