#include <fmt/format.h>

#include <algorithm>

#include "eval/cell/simulated_cell.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/run_progress.h"
#include "eval/draw/bin_view.h"
#include "eval/draw/overlay.h"
#include "eval/export/visibility_csv.h"
#include "eval/summary/setting_notes.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {

int RenderCommand(int argc, char** argv) {
  CLI::App app(
      fmt::format(
          "Fills one bin and writes the camera image: color.png, depth.png (16 bit, 0.1 mm per "
          "unit, 0 = no reading, with sensor noise), ids.png (16 bit, instance + 1), pictures of "
          "depth and ids, a picture with materials and shadows for people ({}), and {}.",
          kPictureFile, kVisibilityFile),
      "pickbed render");
  ScenarioRequest arguments;
  std::string out;
  int trial = 0;
  AddScenarioArguments(app, arguments);
  AddOutArgument(app, out, "-render");
  app.add_option("--trial", trial, "number of the trial of the scenario, from 0")
      ->check(WithoutUpperLimit())
      ->capture_default_str();
  app.footer("Example: pickbed render demo --set camera.width=1280 --set camera.height=960");
  if (!ParseArguments(app, argc, argv)) return 0;

  const BinIndex bin_index(trial);
  ProgressLine progress;
  const ObjectProgress on_object = ShowObjectsOn(progress);
  const LoadedScenario scenario = FindScenario(arguments, on_object);
  const std::filesystem::path folder = OutFolder(out, scenario.name, "-render");
  fmt::print(stderr, "{}", SmallObjectNote(scenario.spec, scenario.objects));
  MakeFolder(folder);
  SimulatedCell cell(scenario.spec, scenario.objects);
  cell.SetOnPrepare(on_object);
  const Scene scene = cell.MakeScene(bin_index).scene;
  const Observation view = cell.Capture(scene, bin_index, 0);
  WritePng(folder / "color.png", view.frame.color);
  WritePng(folder / kPictureFile,
           cell.PictureOf(scene, bin_index, BinCamera(cell.camera(), cell.bin())).color);
  WriteDepthPng(folder / "depth.png", view.frame.depth_m);
  WritePng(folder / "depth_color.png", ColorizeDepth(view.frame.depth_m));
  WritePng16(folder / "ids.png", view.ids);
  WritePng(folder / "ids_color.png", ColorizeIds(view.ids));
  WriteFileAtomically(folder / kVisibilityFile, VisibilityCsv(scene, view, cell.objects()));
  const auto in_view = std::count_if(view.visible_fractions.begin(), view.visible_fractions.end(),
                                     [](double fraction) { return fraction > 0; });
  fmt::print("{} of {} instances are visible to the camera; pictures in {}\n", in_view,
             scene.objects.size(), folder.string());
  return 0;
}

}  // namespace pickbed::eval
