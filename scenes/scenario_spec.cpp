#include "scenes/scenario_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scenes/check.h"
#include "scenes/files.h"

namespace pickbed {
namespace {

// In the walls, the floor or the room for parts between them.
bool InsideBin(const BinSpec& bin, const Eigen::Vector3d& p_W) {
  const Eigen::Vector2d outer = 0.5 * bin.inner_size_m.head<2>().array() + bin.wall_m;
  return (p_W.head<2>().cwiseAbs().array() <= outer.array()).all() && p_W.z() >= -bin.wall_m &&
         p_W.z() <= bin.inner_size_m.z();
}

void ValidateCamera(const ScenarioSpec& spec) {
  const CameraSpec& camera = spec.camera;
  if (InsideBin(spec.bin, camera.eye_m)) {
    throw InputError(
        fmt::format("{} = [{}, {}, {}]: the camera stands inside the bin or its wall; raise it",
                    spec.At("camera.eye_m"), camera.eye_m.x(), camera.eye_m.y(), camera.eye_m.z()));
  }
  if ((camera.target_m - camera.eye_m).norm() < 1e-3) {
    throw InputError(fmt::format("{}: equals camera.eye_m; aim the camera at the bin's floor",
                                 spec.At("camera.target_m")));
  }
  const Camera view = CameraOf(spec);
  const Eigen::Vector3d middle_W(0, 0, 0.5 * spec.bin.inner_size_m.z());
  const Eigen::Vector3d middle_C = view.X_WC.inverse() * middle_W;
  const Eigen::Array2d middle_px = Project(view.intrinsics, middle_C).array();
  const Eigen::Array2d last_px(camera.width - 1, camera.height - 1);
  if (middle_C.z() <= 0 || (middle_px < 0).any() || (middle_px > last_px).any()) {
    throw InputError(fmt::format(
        "{} = [{}, {}, {}]: the camera looks away from the bin; aim it at [0, 0, 0]",
        spec.At("camera.target_m"), camera.target_m.x(), camera.target_m.y(), camera.target_m.z()));
  }
}

constexpr double kSmallestFloor_m = 0.02;

// What the scenario does not say of its bin, the bin's file does. A name that --set gives replaces
// what the scenario file says of it.
void FillInBin(ScenarioSpec& spec) {
  if (spec.bin.name.empty()) return;
  BinSpec bin = BlameKey(spec, "bin.name", [&] { return LoadBin(spec.bin.name); });
  const auto is_set = [&](const std::string& key) {
    const auto place = spec.places.find(key);
    return place != spec.places.end() && place->second.starts_with("--set");
  };
  const auto is_given = [&](const std::string& key) {
    return is_set("bin.name") ? is_set(key) : spec.places.contains(key);
  };
  bin.name = spec.bin.name;
  if (is_given("bin.inner_size_m")) bin.inner_size_m = spec.bin.inner_size_m;
  if (is_given("bin.wall_m")) bin.wall_m = spec.bin.wall_m;
  if (is_given("bin.friction")) bin.friction = spec.bin.friction;
  spec.bin = bin;
}

}  // namespace

void PartSpec::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "a part of the catalog, or a name of your own with mesh and mass_kg");
  v.Integer("count", count, {1, 1000}, "how many are dropped");
  v.Text("mesh", mesh, {}, "mesh file, relative to this file; empty = from the catalog");
  v.Text("unit", unit, {"m", "cm", "mm", "in"}, "of the mesh's coordinates");
  v.Real("mass_kg", mass_kg, {0, 100}, "mass of the part, kg; only with mesh");
  v.Real("friction", friction, {0.01, 2}, "against a gripper pad; only with mesh");
}

void CameraSpec::Visit(SettingsVisitor& v) {
  v.Integer("width", width, {32, 4096}, "image width, px");
  v.Integer("height", height, {32, 4096}, "image height, px");
  v.Real("focal_px", focal_px, {20, 20000}, "focal length, px");
  v.Real("focal_y_px", focal_y_px, {0, 20000}, "vertical focal length, px; 0 = as focal_px");
  v.Vector2("principal_px", principal_px, {-1, 4096}, "principal point, px; -1 = the middle");
  v.Vector3("eye_m", eye_m, {-10, 10}, "where the camera stands, world, m");
  v.Vector3("target_m", target_m, {-10, 10}, "what it looks at, world, m");
}

void EstimatorSpec::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "a row of `pickbed list estimators`");
  v.Text("model", model, {}, "trained model: a file, or a name in assets/models; empty = shipped");
  v.Text("mode", mode, {"fast", "hard"}, "fast or thorough search");
  v.Real("min_score", min_score, {0, 1}, "poses less sure than this are not reported");
  v.Real("noise_mm", noise_mm, {0, 1000}, "oracle only: sigma of the position, each axis, mm");
  v.Real("noise_deg", noise_deg, {0, 180}, "oracle only: sigma of the rotation, degrees");
}

void PolicySpec::Visit(SettingsVisitor& v) {
  v.Text("stop", stop, {"until_empty", "one_pick"}, "when a trial ends");
  v.Integer("max_failures_in_row", max_failures_in_row, {1, 1000}, "failed picks in a row");
  v.Integer("max_picks", max_picks, {0, 100000}, "picks a trial, 0 = no limit");
}

void BinSpec::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "a row of `pickbed list bins`, or a file; its own keys may be left out");
  v.Vector3("inner_size_m", inner_size_m, {0, 5},
            "inner length x, width y, height z, m; 0 = table");
  v.Real("wall_m", wall_m, {0.001, 0.1}, "thickness of walls and floor, m");
  v.Real("friction", friction, {0, 2}, "own value of the pair rule");
}

void ScenarioSpec::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "same seed, same results");
  v.Integer("trials", trials, {1, 1000000}, "bins to fill");
  v.Group(
      "bin", [this](SettingsVisitor& g) { bin.Visit(g); }, "the bin");
  v.List(
      "objects", objects.size(), [this](size_t n) { objects.assign(n, PartSpec{}); },
      [this](size_t i, SettingsVisitor& item) { objects[i].Visit(item); }, "what is dropped");
  v.Text("arrangement", arrangement, {"pile", "packed", "heap"},
         "poured in, stood apart and upright, or heaped in the middle");
  v.Group(
      "camera", [this](SettingsVisitor& g) { camera.Visit(g); }, "the depth camera");
  v.Text("sensor", sensor, {}, "a row of `pickbed list sensors`, or a file");
  v.Group(
      "estimator", [this](SettingsVisitor& g) { estimator.Visit(g); }, "who guesses poses");
  v.Text("refiner", refiner, {"pcl_icp", "two_way_icp", "none"}, "what polishes reported poses");
  v.Text("gripper", gripper, {}, "a row of `pickbed list grippers`, or a file");
  v.Group(
      "policy", [this](SettingsVisitor& g) { policy.Visit(g); }, "how picking goes on");
}

std::vector<std::string> BinNames() { return StemsIn(AssetsDir() / "bins", ".yaml"); }

BinSpec LoadBin(const std::string& name_or_path) {
  const std::filesystem::path path = name_or_path;
  const bool is_file = path.extension() == ".yaml";
  if (!is_file) {
    const std::vector<std::string> names = BinNames();
    CheckInput(std::find(names.begin(), names.end(), name_or_path) != names.end(),
               UnknownNameMessage("bin", name_or_path, names));
  }
  BinSpec bin;
  ReadSettingsFile(is_file ? path : AssetsDir() / "bins" / (name_or_path + ".yaml"),
                   [&bin](SettingsVisitor& v) { bin.Visit(v); });
  return bin;
}

std::string ScenarioSpec::At(const std::string& key) const {
  const auto place = places.find(key);
  return place == places.end() ? key : place->second + ": " + key;
}

void ScenarioSpec::Validate() const {
  CheckInput(bin.inner_size_m.head<2>().minCoeff() >= kSmallestFloor_m,
             fmt::format("{} = [{}, {}, {}]: length and width must be {} m at least",
                         At("bin.inner_size_m"), bin.inner_size_m.x(), bin.inner_size_m.y(),
                         bin.inner_size_m.z(), kSmallestFloor_m));
  CheckInput(!objects.empty(),
             At("objects") + ": the scenario drops nothing; add '- {name: rod, count: 5}'");
  std::set<std::string> names;
  for (size_t i = 0; i < objects.size(); ++i) {
    const PartSpec& part = objects[i];
    const std::string key = fmt::format("objects.{}.", i);
    CheckInput(!part.name.empty(), fmt::format("{}name: is missing; name the part", key));
    CheckInput(names.insert(part.name).second,
               fmt::format("{} = {}: is listed twice; raise its count instead", At(key + "name"),
                           part.name));
    const std::string mass = fmt::format("{} = {}", At(key + "mass_kg"), part.mass_kg);
    CheckInput(part.mesh.empty() || part.mass_kg > 0,
               mass + ": must be over 0 for a part given by mesh");
    CheckInput(!part.mesh.empty() || part.mass_kg == 0,
               fmt::format("{}: '{}' comes from the catalog, which has its mass; remove it or give "
                           "a mesh",
                           mass, part.name));
  }
  ValidateCamera(*this);
}

ScenarioSpec LoadScenario(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides) {
  ScenarioSpec spec;
  const VisitFunction visit = [&spec](SettingsVisitor& v) { spec.Visit(v); };
  spec.places = ReadSettingsFile(file, visit);
  for (const std::string& assignment : overrides) {
    for (const auto& [key, place] : ApplySetting(assignment, visit)) spec.places[key] = place;
  }
  spec.folder = std::filesystem::absolute(file).parent_path();
  FillInBin(spec);
  try {
    spec.Validate();
  } catch (const InputError& error) {
    // A key that was not given has no place of its own.
    const std::string message = error.what();
    const bool has_place = message.starts_with(file.string()) || message.starts_with("--set ");
    throw InputError(has_place ? message : fmt::format("{}: {}", file.string(), message));
  }
  return spec;
}

namespace {

std::shared_ptr<const ObjectModel> LoadPart(const ScenarioSpec& spec, const PartSpec& part,
                                            const ObjectCatalog& catalog) {
  if (part.mesh.empty()) return catalog.Load(part.name);
  MeshPartSpec mesh_part;
  mesh_part.mesh = spec.folder / part.mesh;
  mesh_part.unit = part.unit;
  mesh_part.mass_kg = part.mass_kg;
  mesh_part.friction = part.friction;
  return LoadMeshPart(part.name, mesh_part);
}

// Its two smallest sides must pass between the walls, its largest must fit on the diagonal.
void RequireFits(const ObjectModel& model, const BinSpec& bin) {
  Eigen::Vector3d size = MeshBounds(model.mesh_O).size();
  std::sort(size.data(), size.data() + 3);
  const Eigen::Vector2d inner = bin.inner_size_m.head<2>();
  if (size[1] <= inner.minCoeff() && size[2] <= inner.norm()) return;
  throw InputError(fmt::format(
      "part '{}' of {:.0f} x {:.0f} x {:.0f} mm is larger than the bin of {:.0f} x {:.0f} mm; "
      "check its unit or choose a larger bin.inner_size_m",
      model.name, 1e3 * size[0], 1e3 * size[1], 1e3 * size[2], 1e3 * inner[0], 1e3 * inner[1]));
}

}  // namespace

ObjectSet LoadObjects(const ScenarioSpec& spec, const ObjectCatalog& catalog) {
  ObjectSet objects;
  for (size_t i = 0; i < spec.objects.size(); ++i) {
    const PartSpec& part = spec.objects[i];
    const char* key = part.mesh.empty() ? "name" : "mesh";
    BlameKey(spec, fmt::format("objects.{}.{}", i, key), [&] {
      objects.push_back(LoadPart(spec, part, catalog));
      RequireFits(*objects.back(), spec.bin);
    });
  }
  return objects;
}

Bin BinOf(const ScenarioSpec& spec) {
  return {spec.bin.inner_size_m, spec.bin.wall_m, spec.bin.friction};
}

Camera CameraOf(const ScenarioSpec& spec) {
  const CameraSpec& c = spec.camera;
  Camera camera;
  camera.intrinsics = {c.width,
                       c.height,
                       c.focal_px,
                       c.focal_y_px > 0 ? c.focal_y_px : c.focal_px,
                       c.principal_px.x() < 0 ? 0.5 * (c.width - 1) : c.principal_px.x(),
                       c.principal_px.y() < 0 ? 0.5 * (c.height - 1) : c.principal_px.y()};
  const Eigen::Vector3d sight = (c.target_m - c.eye_m).normalized();
  // Straight down there is no "up" along z: let the image's top be the bin's +y.
  const bool vertical = std::abs(sight.z()) > 0.999;
  camera.X_WC =
      LookAt(c.eye_m, c.target_m, vertical ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
  return camera;
}

}  // namespace pickbed
