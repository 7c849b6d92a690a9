#include "eval/train/job.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/bop/layout.h"
#include "eval/bop/models.h"
#include "perception/networks/model_file.h"
#include "scenes/base/error.h"
#include "sim/convex/convex_pieces.h"
#include "sim/training_view_source.h"

namespace pickbed::eval {
namespace {

// Range of camera distances for training, relative to the scenario.
constexpr double kNearest = 0.88;
constexpr double kFarthest = 1.15;
// The default cell fits objects of this diameter. Without a scenario, the cell is scaled with the
// object.
constexpr double kUsualDiameter_m = 0.095;

// Minimum diameter of an object in the image for training, px.
constexpr int kMinPixels = 10;

// Objects known to the initial model are trained again, so that the model does not forget them.
void AddKnownObjects(const TrainingSetChoice& choice, TrainingSet& training_set) {
  const ObjectCatalog catalog = OpenCatalog(choice.scenario.catalog);
  const std::filesystem::path file = choice.start_from;
  for (const ModelObject& known : LoadModel(file).info.objects) {
    const auto is_known = [&](const auto& object) { return object->name == known.name; };
    if (std::any_of(training_set.objects.begin(), training_set.objects.end(), is_known)) continue;
    const std::vector<std::string> names = catalog.Names();
    CheckInput(std::find(names.begin(), names.end(), known.name) != names.end(),
               fmt::format("{}: it was trained for object '{}', which is in no catalog, so it "
                           "would be lost; add its catalog or name a scenario that has it",
                           file.string(), known.name));
    const auto object = catalog.Load(known.name);
    CheckInput(object->mesh_hash == known.mesh_hash,
               fmt::format("{}: the mesh of object '{}' has changed since training; name the "
                           "object to train it again",
                           file.string(), known.name));
    training_set.objects.push_back(object);
  }
}

// Checked before minutes of rendering: an object of few pixels cannot be learned.
void RequireVisibleObjects(const TrainingSet& training_set) {
  const double distance_m = training_set.spec.camera.eye_m.norm();
  for (const auto& object : training_set.objects) {
    const double pixels =
        CameraOf(training_set.spec).intrinsics.fx() * object->diameter_m / (kFarthest * distance_m);
    CheckInput(pixels >= kMinPixels,
               fmt::format("object '{}' is only {:.1f} px large at {:.2f} m, but training needs at "
                           "least {} px; move the camera nearer (camera.eye_m), raise "
                           "camera.focal_px or check the unit of the mesh",
                           object->name, pixels, kFarthest * distance_m, kMinPixels));
  }
}

// Checks the sensor of the scenario, or the sensors used for clutter scenes instead.
void RequireFloorInRange(const TrainingSet& training_set) {
  const double floor_m = CameraOf(training_set.spec).X_CW().translation().z();
  for (const SensorProfile& sensor : training_set.sensors) RequireInRange(sensor, floor_m);
  if (!training_set.sensors.empty()) return;
  WithSettingsKey(training_set.spec, "sensor",
                  [&] { RequireInRange(LoadSensorProfile(training_set.spec.sensor), floor_m); });
}

// Returns the appearance ranges of the scenario. Light settings that the scenario leaves at their
// default are varied nevertheless.
AppearanceRanges TrainingAppearance(const AppearanceRanges& of_scenario) {
  const AppearanceRanges fixed = FixedAppearance(), varied;
  AppearanceRanges appearance = of_scenario;
  for (Span AppearanceRanges::*span : {&AppearanceRanges::lamp_x_m, &AppearanceRanges::lamp_y_m,
                                       &AppearanceRanges::lamp_z_m, &AppearanceRanges::ambient}) {
    if (appearance.*span == fixed.*span) appearance.*span = varied.*span;
  }
  return appearance;
}

}  // namespace

TrainingSet PlanTrainingSet(const TrainingSetChoice& choice) {
  TrainingSet training_set;
  if (!choice.scenario.scenario.empty()) {
    LoadedScenario loaded = FindScenario(choice.scenario);
    ObjectSet learned;
    for (size_t i = 0; i < loaded.objects.size(); ++i) {
      if (!loaded.spec.objects[i].distractor) learned.push_back(loaded.objects[i]);
    }
    training_set.name = loaded.name;
    training_set.spec = std::move(loaded.spec);
    training_set.has_cell = true;
    training_set.objects = std::move(learned);
  }
  if (!choice.bop_path.empty()) {
    CheckInput(choice.objects.empty() && training_set.objects.empty(),
               "a BOP dataset replaces objects and scenario; give one or the other");
    const std::filesystem::path root = choice.bop_path;
    training_set.name = (std::filesystem::absolute(root) / ".")
                            .lexically_normal()
                            .parent_path()
                            .filename()
                            .string();
    training_set.objects = LoadDatasetObjects(root).objects;
    const auto camera = ReadDatasetCamera(root / kDatasetCameraFile, ThrowFault);
    if (camera) training_set.camera = camera->intrinsics;
  }
  if (!choice.objects.empty()) {
    const ObjectCatalog catalog = OpenCatalog(choice.scenario.catalog);
    training_set.objects.clear();
    training_set.name.clear();
    for (const std::string& name : choice.objects) {
      training_set.objects.push_back(catalog.Load(name));
      training_set.name += training_set.name.empty() ? name : "-" + name;
    }
  }
  CheckInput(!training_set.objects.empty(),
             "no objects to train for: name objects of the catalog or a scenario");
  for (const std::string& name : choice.sensors) {
    training_set.sensors.push_back(LoadSensorProfile(name));
  }
  training_set.distractor_share = choice.distractor_share;
  training_set.deep_share = choice.deep_share;
  if (!choice.start_from.empty()) AddKnownObjects(choice, training_set);
  if (training_set.has_cell) {
    RequireVisibleObjects(training_set);
    RequireFloorInRange(training_set);
  }
  return training_set;
}

std::unique_ptr<LabelledViewSource> MakeTrainingViews(const TrainingSet& training_set) {
  ViewSourceOptions options;
  options.sensor = WithSettingsKey(training_set.spec, "sensor",
                                   [&] { return LoadSensorProfile(training_set.spec.sensor); });
  options.scene_sensors = training_set.sensors;
  // An image without a known background may be from any camera.
  options.room_sensors = training_set.sensors;
  if (training_set.sensors.empty()) options.room_sensors.push_back(options.sensor);
  for (const char* name : {"kinect_v1", "structured_light", "active_stereo"}) {
    options.room_sensors.push_back(LoadSensorProfile(name));
  }
  options.distractor_share = training_set.distractor_share;
  options.deep_share = training_set.deep_share;
  options.appearance = TrainingAppearance(training_set.spec.appearance);
  options.camera = training_set.camera.value_or(CameraOf(training_set.spec).intrinsics);
  options.bin = BinOf(training_set.spec);
  // The camera of a cell is fixed. But objects are at different heights, and the mounting height
  // varies by about 10 cm.
  const double distance_m = training_set.spec.camera.eye_m.norm();
  options.distance_min_m = kNearest * distance_m;
  options.distance_max_m = kFarthest * distance_m;
  if (!training_set.has_cell) options.for_diameter_m = kUsualDiameter_m;
  return MakeSimViewSource(WithConvexPieces(training_set.objects), options);
}

std::string SensorNames(const TrainingSet& training_set) {
  if (training_set.sensors.empty()) return training_set.spec.sensor;
  std::vector<std::string> names;
  for (const SensorProfile& sensor : training_set.sensors) names.push_back(sensor.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace pickbed::eval
