#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/bin_view.h"
#include "eval/export/scene_json.h"
#include "eval/summary/clutter_json.h"
#include "eval/trial/clutter.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

// The scene is measured at true poses, so no estimator is loaded.
TrialOptions PerceptionGiven() {
  TrialOptions options;
  options.truth = {true, true, true, true, false};
  return options;
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
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.footer("Example: pickbed drop demo --set objects.0.count=30 --trial 2");
  if (!ParseArguments(app, argc, argv)) return 0;

  const BinIndex bin_index(trial);
  const LoadedScenario scenario = FindScenario(arguments);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-drop");
  MakeFolder(folder);
  TrialSetup setup(scenario.spec, scenario.objects, {}, PerceptionGiven());
  SimulatedCell& cell = setup.cell;
  const CertifiedScene made = cell.MakeScene(bin_index);
  WriteFileAtomically(folder / kSceneFile, SceneJson(made.scene, cell.objects()));
  WritePng(folder / "color.png", cell.ColorPicture(made.scene, bin_index));
  WritePng(folder / kPictureFile,
           cell.PictureOf(made.scene, bin_index, BinCamera(cell.camera(), cell.bin())).color);
  WriteFileAtomically(folder / kCertificateFile, CertificateJson(made));
  const ClutterSummary clutter = ClutterOfBin(
      MeasureClutter(setup, made.scene, bin_index, cell.Capture(made.scene, bin_index, 0)));
  WriteFileAtomically(folder / kClutterFile, ClutterJson(clutter, scenario.spec.gripper.InWords()));
  fmt::print("{}{}wrote {}, {}, {}, color.png and {}\n", CertificateText(made),
             ClutterText(clutter, scenario.spec.gripper.InWords()), (folder / kSceneFile).string(),
             kCertificateFile, kClutterFile, kPictureFile);
  return 0;
}

}  // namespace pickbed::eval
