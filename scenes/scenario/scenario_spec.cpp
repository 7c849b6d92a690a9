#include "scenes/scenario/scenario_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/network_address.h"

namespace pickbed::scenes {
namespace {

// Returns whether a point is in the walls, in the floor or in the space between them.
bool InsideBin(const BinSpec& bin, const Eigen::Vector3d& p_W) {
  const Eigen::Vector2d outer = 0.5 * bin.inner_size_m.head<2>().array() + bin.wall_m;
  return (p_W.head<2>().cwiseAbs().array() <= outer.array()).all() && p_W.z() >= -bin.wall_m &&
         p_W.z() <= bin.inner_size_m.z();
}

void ValidateCamera(const ScenarioSpec& spec) {
  const CameraSpec& camera = spec.camera;
  if (InsideBin(spec.bin, camera.eye_m)) {
    throw InputError(
        fmt::format("{} = [{}, {}, {}]: the camera is inside the bin or its wall; raise it",
                    spec.At("camera.eye_m"), camera.eye_m.x(), camera.eye_m.y(), camera.eye_m.z()));
  }
  if (camera.eye_m.z() < -spec.bin.wall_m) {
    throw InputError(
        fmt::format("{} = [{}, {}, {}]: the camera is under the bin's floor and cannot see the "
                    "instances; raise it",
                    spec.At("camera.eye_m"), camera.eye_m.x(), camera.eye_m.y(), camera.eye_m.z()));
  }
  if ((camera.target_m - camera.eye_m).norm() < 1e-3) {
    throw InputError(fmt::format("{}: equals camera.eye_m; aim the camera at the bin's floor",
                                 spec.At("camera.target_m")));
  }
  const Camera view = CameraOf(spec);
  const Eigen::Vector3d center_W(0, 0, 0.5 * spec.bin.inner_size_m.z());
  const Eigen::Vector3d center_C = view.X_CW() * center_W;
  const Eigen::Array2d center_px = Project(view.intrinsics, center_C).array();
  const Eigen::Array2d last_px(camera.width - 1, camera.height - 1);
  if (center_C.z() <= 0 || (center_px < 0).any() || (center_px > last_px).any()) {
    throw InputError(fmt::format(
        "{} = [{}, {}, {}]: the camera looks away from the bin; aim it at [0, 0, 0]",
        spec.At("camera.target_m"), camera.target_m.x(), camera.target_m.y(), camera.target_m.z()));
  }
}

constexpr double kSmallestFloor_m = 0.02;

void RequireFloor(const BinSpec& bin, const std::string& place) {
  CheckInput(bin.inner_size_m.head<2>().minCoeff() >= kSmallestFloor_m,
             fmt::format("{} = [{}, {}, {}]: length and width must be at least {} m", place,
                         bin.inner_size_m.x(), bin.inner_size_m.y(), bin.inner_size_m.z(),
                         kSmallestFloor_m));
}

// Uses the measures of the mesh for keys that are not given.
void TakeMeasures(const std::function<bool(const std::string&)>& is_given, BinSpec& bin) {
  const BinShape& shape = *bin.shape;
  if (!is_given("inner_size_m")) bin.inner_size_m = shape.inner_size_m;
  if (!is_given("wall_m")) bin.wall_m = shape.wall_m;
  // The tolerance accepts a measured size that was written with fewer digits.
  const bool fits = (bin.inner_size_m.head<2>().array() <= shape.opening_m.array() + 1e-4).all();
  CheckInput(fits,
             fmt::format("inner_size_m = [{}, {}, {}] is larger than the opening of {}, which "
                         "is {:.4f} x {:.4f} m; leave it out to have it measured",
                         bin.inner_size_m.x(), bin.inner_size_m.y(), bin.inner_size_m.z(), bin.mesh,
                         shape.opening_m.x(), shape.opening_m.y()));
}

void LoadShape(const std::filesystem::path& folder, BinSpec& bin) {
  bin.shape = std::make_shared<const BinShape>(LoadBinShape(folder / bin.mesh, bin.unit));
}

// Takes the keys of the bin that the scenario does not give from the bin's file. If an
// assignment gives the name, the bin keys of the scenario file are ignored.
void FillInBin(ScenarioSpec& spec) {
  const auto is_set = [&](const std::string& key) {
    const auto place = spec.places.find(key);
    return place != spec.places.end() && place->second.starts_with(kAssignmentPlace);
  };
  const auto is_given = [&](const std::string& key) {
    return is_set("bin.name") ? is_set("bin." + key) : spec.places.contains("bin." + key);
  };
  const BinSpec given = spec.bin;
  if (!given.name.empty()) {
    spec.bin = WithSettingsKey(spec, "bin.name", [&] { return LoadBin(given.name); });
    spec.bin.name = given.name;
  }
  if (is_given("friction")) spec.bin.friction = given.friction;
  const bool own_mesh = !given.mesh.empty() && (given.name.empty() || is_given("mesh"));
  if (own_mesh) {
    spec.bin.mesh = given.mesh;
    spec.bin.unit = given.unit;
    WithSettingsKey(spec, "bin.mesh", [&] { LoadShape(spec.folder, spec.bin); });
  }
  if (is_given("inner_size_m")) spec.bin.inner_size_m = given.inner_size_m;
  if (is_given("wall_m")) spec.bin.wall_m = given.wall_m;
  if (!spec.bin.shape) return;
  const auto is_known = [&](const std::string& key) { return !own_mesh || is_given(key); };
  WithSettingsKey(spec, is_given("inner_size_m") ? "bin.inner_size_m" : "bin.mesh",
                  [&] { TakeMeasures(is_known, spec.bin); });
}

// Adds the bin's file and mesh to the settings that were read from `name`, and validates them.
ScenarioSpec Completed(ScenarioSpec spec, const std::filesystem::path& folder,
                       const std::string& name) {
  spec.folder = folder;
  FillInBin(spec);
  try {
    spec.Validate();
  } catch (const InputError& error) {
    // An error about a key that was not given has no place at its beginning.
    const std::string message = error.what();
    const bool has_place = message.starts_with(name) || message.starts_with(kAssignmentPlace);
    throw InputError(has_place ? message : fmt::format("{}: {}", name, message));
  }
  return spec;
}

}  // namespace

void ObjectSpec::Visit(SettingsVisitor& v) {
  v.Text("name", name, {},
         "name of a catalog object, or a new name together with mesh and mass_kg; "
         "sampled/FAMILY/0-39 gives 40 sampled shapes");
  v.Integer("count", count, {1, 1000}, "number of dropped instances");
  v.Text("mesh", mesh, {},
         "mesh file, relative to this file; * and ? in its name give all files that match; empty = "
         "from the catalog");
  v.Text("unit", unit, {"m", "cm", "mm", "in"}, "unit of the mesh coordinates");
  v.Real("mass_kg", mass_kg, {0, 100}, "mass of the object, kg; only with mesh");
  v.Real("density_kgpm3", density_kgpm3, {0, 30000},
         "density of a uniform solid, kg/m^3, instead of mass_kg; only with mesh");
  v.Real("friction", friction, {0.01, 2},
         "coefficient of friction against a gripper pad; only with mesh");
  v.RenamedKey("foreign", "distractor");
  v.Bool("distractor", distractor,
         "whether the instances are distractors: unknown to the estimator and not to be picked");
}

void CameraSpec::Visit(SettingsVisitor& v) {
  v.Integer("width", width, {32, 4096}, "image width, px");
  v.Integer("height", height, {32, 4096}, "image height, px");
  v.Real("focal_px", focal_px, {20, 20000}, "focal length, px");
  v.Real("focal_y_px", focal_y_px, {0, 20000}, "vertical focal length, px; 0 = focal_px");
  v.Vector2("principal_px", principal_px, {-1, 4096}, "principal point, px; -1 = the image center");
  v.Vector3("eye_m", eye_m, {-10, 10}, "position of the camera in the world frame, m");
  v.Vector3("target_m", target_m, {-10, 10},
            "point in the world frame at which the camera looks, m");
}

void FirstPosesSpec::Visit(SettingsVisitor& v) {
  v.Integer("poses", poses, {1, 1000}, "number of graspable poses at which the search ends");
  v.Real("confidence", confidence, {0, 1}, "minimum score of a pose that counts");
}

void EstimatorSpec::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "name of the estimator, a row of `pickbed list estimators`");
  v.Text("model", model, {},
         "trained model: a file, or a name in assets/models; empty = the shipped model");
  v.RenamedValue("mode", "hard", "accurate");
  v.Text("mode", mode, {"fast", "accurate", "first", "verified"},
         "search mode; verified is only for estimator ppf");
  v.Group(
      "first", [this](SettingsVisitor& g) { first.Visit(g); }, "settings of the mode first");
  v.Real("min_score", min_score, {0, 1},
         "minimum score of a reported pose, after the calibration; raw scores have no minimum. "
         "`pickbed estimate IMAGE` and `--bop --explain` have the default 0.6, `--bop` has 0");
  v.Text("calibration", calibration, {},
         "file of `pickbed calibrate`, which converts the scores into probabilities; empty = the "
         "scores are used as they are");
  v.Text("calibrated_to", calibrated_to, {"pose_right", "pick_succeeds"},
         "probability into which the calibration converts the scores");
  v.Text("completion", completion, {},
         "method that completes the shapes of occluded segments for additional poses: none, or a "
         "method of `pickbed benchmark completion` but truth; only for estimator descriptor");
  v.Text("completion_model", completion_model, {},
         "model of completion method network or vae: a file, or a name in assets/models");
  v.Real("noise_mm", noise_mm, {0, 1000},
         "standard deviation of the position error per axis, mm; only for estimator oracle");
  v.Real("noise_deg", noise_deg, {0, 180},
         "standard deviation of the rotation error, degrees; only for estimator oracle");
  v.Words("command", command,
          "program that estimates the poses, and its arguments; only for estimator process");
  v.Text("connect", connect, {},
         "address host:port of a program that estimates the poses, instead of a command; only for "
         "estimator process");
  v.Real("timeout_s", timeout_s, {0.01, 86400},
         "maximum time for each answer of the program, s; only for estimator process");
  v.Text("scores", scores, {"probability", "raw"},
         "whether scores are probabilities, or of any scale: poses are then ranked in each image "
         "until they are calibrated; only for estimator process");
}

void BinSpec::Visit(SettingsVisitor& v) {
  v.Text(
      "name", name, {},
      "name of the bin, a row of `pickbed list bins`, or its file; the other keys may be omitted");
  v.Text("mesh", mesh, {}, "mesh file of a bin of any shape, z up, relative to this file");
  v.Text("unit", unit, {"m", "cm", "mm", "in"}, "unit of the mesh coordinates");
  v.Vector3(
      "inner_size_m", inner_size_m, {0, 5},
      "inner length x, width y and height z, m; height 0 = table; measured if a mesh is given");
  v.Real("wall_m", wall_m, {0.001, 0.1}, "thickness of walls and floor, m");
  v.Real("friction", friction, {0, 2},
         "coefficient of friction of the bin; a contact combines it with the other body's");
}

void ScenarioSpec::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed; equal seeds give equal results");
  v.Integer("trials", trials, {1, 1000000}, "number of bins to fill");
  v.Real("stop_width", stop_width, {0, 1},
         "the run ends early once the interval of pick success is no wider than this; 0 = never");
  v.Group(
      "bin", [this](SettingsVisitor& g) { bin.Visit(g); }, "bin that holds the objects");
  v.List(
      "objects", objects.size(), [this](size_t n) { objects.assign(n, ObjectSpec{}); },
      [this](size_t i, SettingsVisitor& item) { objects[i].Visit(item); },
      "objects that are dropped");
  v.Integer("draw", draw, {0, 10000},
            "number of instances that each bin draws from all of these, distractors not counted; 0 "
            "= every bin gets all");
  v.Text("arrangement", arrangement, {"pile", "packed", "heap"},
         "whether instances are poured in, placed apart and upright, or heaped in the center");
  v.Real("fill", fill, {0, 1},
         "mean height of the pile over the bin's inner height; the counts are then relative; 0 = "
         "drop the counts as given");
  v.Group(
      "camera", [this](SettingsVisitor& g) { camera.Visit(g); }, "depth camera");
  v.Text("sensor", sensor, {},
         "name of the sensor profile, a row of `pickbed list sensors`, or its file");
  v.Group(
      "appearance", [this](SettingsVisitor& g) { appearance.Visit(g); },
      "ranges from which lamp, materials and background are drawn: [minimum, maximum]");
  v.Group(
      "estimator", [this](SettingsVisitor& g) { estimator.Visit(g); }, "pose estimator");
  v.RenamedValue("refiner", "two_way_icp", "bidirectional_icp");
  v.Text("refiner", refiner, {},
         "refinement of the reported poses, a row of `pickbed list refiners`");
  v.Names("gripper", gripper.names,
          "name of the gripper, a row of `pickbed list grippers`, or its file; several: the best "
          "one is used for each pick");
  v.Group(
      "planner", [this](SettingsVisitor& g) { planner.Visit(g); }, "grasp planner");
  v.Group(
      "policy", [this](SettingsVisitor& g) { policy.Visit(g); },
      "order of the grasps and end of a trial");
  v.Group(
      "occlusion", [this](SettingsVisitor& g) { occlusion.Visit(g); },
      "series of scenes in which a target is increasingly occluded, instead of emptying bins");
  v.Group(
      "cell", [this](SettingsVisitor& g) { cell.Visit(g); },
      "errors of the cell: standard deviations of what it assumes, does and holds; 0 = exact");
  v.Group(
      "cycle", [this](SettingsVisitor& g) { cycle.Visit(g); },
      "durations that give the number of picks per hour");
  v.Group(
      "roi", [this](SettingsVisitor& g) { roi.Visit(g); },
      "region of interest: poses are only searched and reported in it. A region without a depth "
      "reading in the first image of bin 0 is refused");
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
  const std::filesystem::path file =
      is_file ? path : AssetsDir() / "bins" / (name_or_path + ".yaml");
  const KeyPlaces places = ReadSettingsFile(file, [&bin](SettingsVisitor& v) { bin.Visit(v); });
  if (bin.mesh.empty()) {
    const auto place = places.find("inner_size_m");
    CheckInput(place != places.end(),
               file.string() + ": has neither inner_size_m nor mesh; give one of them");
    RequireFloor(bin, place->second + ": inner_size_m");
    return bin;
  }
  try {
    bin.mesh = (std::filesystem::absolute(file).parent_path() / bin.mesh).string();
    LoadShape({}, bin);
    TakeMeasures([&](const std::string& key) { return places.contains(key); }, bin);
  } catch (const InputError& error) {
    throw InputError(places.at("mesh") + ": mesh: " + error.what());
  }
  return bin;
}

std::string ScenarioSpec::At(const std::string& key) const {
  const auto place = places.find(key);
  return place == places.end() ? key : place->second + ": " + key;
}

void ScenarioSpec::Validate() const {
  ScenarioSpec copy = *this;
  const std::vector<std::string> faults =
      SettingFaults([&copy](SettingsVisitor& v) { copy.Visit(v); },
                    [this](const std::string& key) { return At(key); });
  CheckInput(faults.empty(), fmt::format("{}", fmt::join(faults, "; ")));
  RequireFloor(bin, At("bin.inner_size_m"));
  CheckInput(!objects.empty(),
             At("objects") + ": the scenario drops nothing; add '- {name: rod, count: 5}'");
  CheckInput(
      !std::all_of(objects.begin(), objects.end(),
                   [](const ObjectSpec& object) { return object.distractor; }),
      At("objects") + ": all objects are distractors; at least one must not be a distractor");
  roi.Validate(At("roi"));
  std::set<std::string> names;
  for (size_t i = 0; i < objects.size(); ++i) {
    const ObjectSpec& object = objects[i];
    const std::string key = fmt::format("objects.{}.", i);
    CheckInput(!object.name.empty(), fmt::format("{}name: is missing; name the object", key));
    CheckInput(names.insert(object.name).second,
               fmt::format("{} = {}: is listed twice; raise its count instead", At(key + "name"),
                           object.name));
    const std::string mass = fmt::format("{} = {}", At(key + "mass_kg"), object.mass_kg);
    CheckInput(object.mesh.empty() || object.mass_kg > 0 || object.density_kgpm3 > 0,
               fmt::format("{}: is missing or 0; give mass_kg, the mass of '{}' in kg, "
                           "because the object is given by a mesh, or density_kgpm3",
                           At(key + "mass_kg"), object.name));
    CheckInput(object.mass_kg == 0 || object.density_kgpm3 == 0,
               fmt::format("{} = {}: mass_kg is given, too; remove one of them",
                           At(key + "density_kgpm3"), object.density_kgpm3));
    CheckInput(!object.mesh.empty() || object.density_kgpm3 == 0,
               fmt::format("{} = {}: '{}' comes from the catalog, which has its mass; remove it or "
                           "give a mesh",
                           At(key + "density_kgpm3"), object.density_kgpm3, object.name));
    CheckInput(!object.mesh.empty() || object.mass_kg == 0,
               fmt::format("{}: '{}' comes from the catalog, which has its mass; remove it or give "
                           "a mesh",
                           mass, object.name));
  }
  CheckInput(draw == 0 || fill == 0,
             fmt::format("{} = {}: fill chooses the numbers of instances already; remove one of "
                         "them",
                         At("draw"), draw));
  CheckInput(draw == 0 || !occlusion.enabled,
             fmt::format("{} = {}: an occlusion scenario adds instances one by one; remove draw or "
                         "set occlusion.enabled: false",
                         At("draw"), draw));
  CheckInput(fill == 0 || arrangement == "pile",
             fmt::format("{} = {}: only a pile has a fill level; set arrangement: pile", At("fill"),
                         fill));
  CheckInput(fill == 0 || !occlusion.enabled,
             fmt::format("{} = {}: an occlusion scenario adds instances one by one; remove fill or "
                         "set occlusion.enabled: false",
                         At("fill"), fill));
  CheckInput(fill == 0 || bin.inner_size_m.z() > 0,
             fmt::format("{} = {}: a table has no height to fill; give each object a count instead",
                         At("fill"), fill));
  std::set<std::string> tools;
  for (const std::string& tool : gripper.names) {
    CheckInput(tools.insert(tool).second, fmt::format("{} = {}: {} is listed twice; remove one",
                                                      At("gripper"), gripper.InWords(), tool));
  }
  CheckInput(
      policy.stir.max == 0 || policy.stir.after < policy.max_failures_in_row,
      fmt::format("{} = {}: the trial ends after {} failures in a row, before it stirs; raise "
                  "policy.max_failures_in_row",
                  At("policy.stir.after"), policy.stir.after, policy.max_failures_in_row));
  CheckInput(
      policy.stir.max == 0 || policy.stir.after_failures + 1 < policy.max_failures_in_row ||
          policy.stir.after_failures == 0,
      fmt::format("{} = {}: the trial ends after {} failures in a row, before it stirs; raise "
                  "policy.max_failures_in_row",
                  At("policy.stir.after_failures"), policy.stir.after_failures,
                  policy.max_failures_in_row));
  CheckInput(policy.picks_per_image == 1 || !occlusion.enabled,
             fmt::format("{} = {}: each pick of an occlusion scenario has its own scene and image; "
                         "remove it or set occlusion.enabled: false",
                         At("policy.picks_per_image"), policy.picks_per_image));
  CheckInput(
      policy.retention_g == 0 || policy.retention_g > 1 || policy.retention_load != "weight",
      fmt::format("{} = {}: the weight is 1 g already; set a value above 1, or 0 for no test",
                  At("policy.retention_g"), policy.retention_g));
  CheckInput(!cycle.overlap || cycle.in_bin_s <= cycle.move_s,
             fmt::format("{} = {}: is longer than the whole motion, cycle.move_s = {}; lower it",
                         At("cycle.in_bin_s"), cycle.in_bin_s, cycle.move_s));
  ValidateCamera(*this);
  for (const auto& [key, address] : {std::pair("estimator.connect", &estimator.connect),
                                     std::pair("planner.connect", &planner.connect)}) {
    if (address->empty()) continue;
    WithSettingsKey(*this, key, [&] { return ParseNetworkAddress(*address); });
  }
  appearance.Validate([this](const std::string& key) { return At("appearance." + key); });
  const Camera view = CameraOf(*this);
  cell.Validate(bin.inner_size_m, view.X_CW().translation().norm(), view.intrinsics.fx(),
                [this](const std::string& key) { return At("cell." + key); });
  if (occlusion.enabled) {
    occlusion.Validate([this](const std::string& key) { return At("occlusion." + key); });
  }
}

ScenarioSpec LoadScenario(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides) {
  ScenarioSpec spec;
  const VisitFunction visit = [&spec](SettingsVisitor& v) { spec.Visit(v); };
  spec.places = ReadSettingsFile(file, visit);
  for (const std::string& assignment : overrides) {
    for (const auto& [key, place] : ApplySetting(assignment, visit)) spec.places[key] = place;
  }
  return Completed(std::move(spec), std::filesystem::absolute(file).parent_path(), file.string());
}

ScenarioSpec LoadScenarioText(const std::string& yaml, const std::filesystem::path& folder,
                              const std::string& name) {
  ScenarioSpec spec;
  spec.places = ReadSettingsText(yaml, name, [&spec](SettingsVisitor& v) { spec.Visit(v); });
  return Completed(std::move(spec), std::filesystem::absolute(folder), name);
}

Bin BinOf(const ScenarioSpec& spec) {
  return {spec.bin.inner_size_m, spec.bin.wall_m, spec.bin.friction, spec.bin.shape};
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
  // A camera that looks straight down cannot use z as its up direction. The image's top is then +y.
  const bool vertical = std::abs(sight.z()) > 0.999;
  camera.SetPose(
      LookAt(c.eye_m, c.target_m, vertical ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ()));
  return camera;
}

}  // namespace pickbed::scenes
