#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/bin_view.h"
#include "eval/export/scene_json.h"
#include "eval/trial/simulated_cell.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {

int DropCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format("Fills one bin, simulates until all objects are at rest, and writes {}, {}, the "
                  "image of the camera (color.png) and a picture with materials and shadows for "
                  "people ({}).",
                  kSceneFile, kCertificateFile, kPictureFile),
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
  SimulatedCell cell(scenario.spec, scenario.objects);
  const CertifiedScene made = cell.MakeScene(bin_index);
  WriteFileAtomically(folder / kSceneFile, SceneJson(made.scene, cell.objects()));
  WritePng(folder / "color.png", cell.ColorPicture(made.scene, bin_index));
  WritePng(folder / kPictureFile,
           cell.PictureOf(made.scene, BinCamera(cell.camera(), cell.bin())).color);
  WriteFileAtomically(folder / kCertificateFile, CertificateJson(made));
  fmt::print("{}wrote {}, {}, color.png and {}\n", CertificateText(made),
             (folder / kSceneFile).string(), kCertificateFile, kPictureFile);
  return 0;
}

}  // namespace pickbed::eval
