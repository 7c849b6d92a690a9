#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "eval/cell/simulated_cell.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/runtime/process.h"
#include "eval/store/results_store.h"
#include "eval/trial/estimator_runner.h"
#include "scenes/base/error.h"
#include "scenes/geometry/mass_properties.h"
#include "scenes/scenario/load_objects.h"
#include "sim/drop/drop.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {

namespace {

// Result of one check.
struct Checkup {
  std::string name;
  bool ok = false;
  std::string found;   // measured result, or error message
  std::string remedy;  // instruction if the check failed
  bool is_optional = false;
};

constexpr double kCubeSide_m = 0.04;
constexpr double kCubeMass_kg = 0.1;
constexpr double kCameraHeight_m = 0.6;
constexpr double kDepthTolerance_m = 0.0005;
constexpr double kSideTolerance_px = 1;  // a pixel belongs to the cube if its center does

// Object without a file; its image and resting height are known in closed form.
std::shared_ptr<const ObjectModel> Cube() {
  auto model = std::make_shared<ObjectModel>();
  model->name = "cube";
  const double h = kCubeSide_m / 2;
  for (int corner = 0; corner < 8; ++corner) {
    model->mesh_O.vertices.emplace_back(corner & 1 ? h : -h, corner & 2 ? h : -h,
                                        corner & 4 ? h : -h);
  }
  model->mesh_O.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                             {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  model->mass = UniformMassProperties(model->mesh_O, kCubeMass_kg);
  model->convex_pieces_O = {{model->mesh_O.vertices}};
  model->diameter_m = Diameter(model->mesh_O);
  model->mesh_hash = 1;
  return model;
}

Camera CameraAbove() {
  Camera camera;
  camera.SetPose(
      LookAt({0, 0, kCameraHeight_m}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()));
  return camera;
}

std::string Render() {
  const ObjectSet objects{Cube()};
  const Bin bin;
  const Camera camera = CameraAbove();
  const Scene scene{bin, {{InstanceId{0}, ObjectId{0}, Translation({0, 0, kCubeSide_m / 2})}}};
  SceneRenderer renderer(objects, bin);
  const RenderedImage image = renderer.Render(scene, camera);
  int pixels = 0;
  for (const uint16_t id : image.ids.pixels()) pixels += id == 1;
  const double expected_m = kCameraHeight_m - kCubeSide_m;
  const double side_px = camera.intrinsics.fx() * kCubeSide_m / expected_m;
  const double depth_m =
      image.depth_m(camera.intrinsics.width() / 2, camera.intrinsics.height() / 2);
  const std::string found = fmt::format("{}; cube at {:.4f} m over {} pixels",
                                        renderer.renderer().ContextName(), depth_m, pixels);
  if (std::abs(depth_m - expected_m) > kDepthTolerance_m ||
      std::abs(std::sqrt(pixels) - side_px) > kSideTolerance_px) {
    throw std::runtime_error(fmt::format("{}; expected {:.4f} m over {:.0f} pixels", found,
                                         expected_m, side_px * side_px));
  }
  return found;
}

std::string Settle() {
  Rng rng(0);
  const DropResult drop = DropInstances(Bin(), {Cube()}, {3}, rng);
  const std::string found =
      fmt::format("3 cubes at rest after {:.1f} s, overlap {:.2f} mm", drop.certificate.simulated_s,
                  1e3 * drop.certificate.deepest_penetration_m);
  if (!drop.certificate.at_rest || drop.certificate.blew_up || drop.scene.objects.empty()) {
    throw std::runtime_error("the cubes did not come to rest");
  }
  return found;
}

// Runs one attempt with the estimator and the model shipped with the program.
std::string Network() {
  ScenarioSpec spec = LoadScenario(PresetsDir() / "demo.yaml");
  spec.objects.resize(1);
  const ObjectSpec& object = spec.objects[0];
  SimulatedCell cell(spec, LoadObjects(spec, ObjectCatalog({AssetsDir() / "objects"})));
  EstimatorRunner runner(cell, spec, 1, {});
  const BinIndex bin_index{0};
  const Scene scene = cell.MakeScene(bin_index).scene;
  Rng rng(0);
  const EstimateResult found = runner.Estimate(cell.Capture(scene, bin_index, 0).frame, rng);
  return fmt::format("estimator {} gave {} poses of {} x {} in {:.2f} s", spec.estimator.name,
                     found.hypotheses.size(), object.count, object.name,
                     found.seconds.at("estimate"));
}

std::string Store() {
  // mkdtemp() makes a new folder without access for other users.
  std::string name = (std::filesystem::temp_directory_path() / "pickbed-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make the folder " + name);
  const std::filesystem::path folder = name;
  TrialResult result;
  result.instances_dropped = 3;
  std::vector<TrialResult> read;
  {
    ResultsStore store(folder, "doctor");
    store.Write(result);
    read = store.ReadAll();
  }
  std::filesystem::remove_all(folder);
  if (read.size() != 1 || read[0].instances_dropped != result.instances_dropped) {
    throw std::runtime_error("the result written to " + folder.string() +
                             " could not be read back");
  }
  return "wrote and read a test result in " + folder.parent_path().string();
}

std::string Files() {
  return fmt::format("{} objects in {}; cache in {}",
                     ObjectCatalog({AssetsDir() / "objects"}).Names().size(), AssetsDir().string(),
                     CacheDir().string());
}

// Imports the Python module, of the build or of the installation.
std::string PythonModule() {
  const std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const char* given = std::getenv("PYTHONPATH");
  const std::string path =
      fmt::format("PYTHONPATH={}:{}:{}", (folder / "python").string(),
                  (folder / ".." / PICKBED_PYTHON_PACKAGES).lexically_normal().string(),
                  given == nullptr ? "" : given);
  const ProgramOutput output =
      RunProgram({"env", path, PICKBED_MODULE_PYTHON, "-c",
                  "import pickbed; print('pickbed', pickbed.__version__, 'in', pickbed.__file__)"});
  const std::string line = output.text.substr(0, output.text.find_last_not_of('\n') + 1);
  if (output.status != 0) throw std::runtime_error(line.substr(line.rfind('\n') + 1));
  return line;
}

Checkup Examine(const char* name, const std::function<std::string()>& check, const char* remedy) {
  Checkup checkup{name, false, "", remedy};
  try {
    checkup.found = check();
    checkup.ok = true;
  } catch (const std::exception& error) {
    checkup.found = error.what();
  }
  return checkup;
}

Checkup Optional(Checkup checkup) {
  checkup.is_optional = true;
  return checkup;
}

std::vector<Checkup> ExamineMachine() {
  return {
      Examine("files", Files, "start the installed program, or set PICKBED_ASSETS"),
      Examine("render", Render, "install libosmesa6 (or libegl1 with libegl-mesa0)"),
      Examine("settle", Settle, "install libbullet3.24 with double precision (bullet-float64)"),
      Examine("network", Network,
              "install libtorch1.13 and libopenblas0-pthread; if the model is missing, train it "
              "again with `pickbed train`"),
      Examine("store", Store, "set TMPDIR to a writable folder with free space"),
      Optional(
          Examine("python", PythonModule,
                  "for `import pickbed`, install pybind11-dev and python3-dev and build again")),
  };
}

}  // namespace

int DoctorCommand(int argc, char** argv) {
  CLI::App app(
      "Checks that this machine can render, simulate a drop, run a network and store results, and "
      "whether Python has the module pickbed.",
      "pickbed doctor");
  app.footer("Example: pickbed doctor");
  if (!ParseArguments(app, argc, argv)) return 0;

  int broken = 0;
  for (const Checkup& checkup : ExamineMachine()) {
    const char* verdict = checkup.ok ? "ok" : checkup.is_optional ? "none" : "not ok";
    fmt::print("{:<7}{:<10}{}\n", verdict, checkup.name, checkup.found);
    if (checkup.ok) continue;
    fmt::print("       {}\n", checkup.remedy);
    broken += !checkup.is_optional;
  }
  CheckInput(broken == 0,
             fmt::format("{} checks failed; each remedy is printed below its check", broken));
  return 0;
}

}  // namespace pickbed::eval
