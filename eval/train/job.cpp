#include "eval/train/job.h"

#include <fmt/format.h>

#include <algorithm>

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
constexpr int kLeastPixels = 10;

// Objects known to the initial model are trained again, so that the model does not forget them.
void AddKnownParts(const LessonChoice& choice, TrainingLesson& lesson) {
  const ObjectCatalog catalog = OpenCatalog(choice.scenario.catalog);
  const std::filesystem::path file = choice.start_from;
  for (const ModelObject& known : LoadModel(file).info.objects) {
    const auto is_known = [&](const auto& object) { return object->name == known.name; };
    if (std::any_of(lesson.objects.begin(), lesson.objects.end(), is_known)) continue;
    const std::vector<std::string> names = catalog.Names();
    CheckInput(std::find(names.begin(), names.end(), known.name) != names.end(),
               fmt::format("{}: it knows part '{}', which is in no catalog, so that it would be "
                           "forgotten; pass --catalog or a scenario that has it",
                           file.string(), known.name));
    const auto object = catalog.Load(known.name);
    CheckInput(object->mesh_hash == known.mesh_hash,
               fmt::format("{}: the mesh of part '{}' has changed since training; name the part "
                           "to learn it anew",
                           file.string(), known.name));
    lesson.objects.push_back(object);
  }
}

// Checked before minutes of rendering: an object of few pixels cannot be learned.
void RequireVisibleParts(const TrainingLesson& lesson) {
  const double distance_m = lesson.spec.camera.eye_m.norm();
  for (const auto& object : lesson.objects) {
    const double pixels =
        CameraOf(lesson.spec).intrinsics.fx() * object->diameter_m / (kFarthest * distance_m);
    CheckInput(pixels >= kLeastPixels,
               fmt::format("part '{}' is {:.1f} px large at {:.2f} m, and {} px are the least to "
                           "learn from; bring the camera nearer (camera.eye_m), raise "
                           "camera.focal_px or check the mesh's unit",
                           object->name, pixels, kFarthest * distance_m, kLeastPixels));
  }
}

// Checks the sensor of the scenario, or the sensors used for clutter scenes instead.
void RequireFloorInRange(const TrainingLesson& lesson) {
  const double floor_m = CameraOf(lesson.spec).X_CW().translation().z();
  for (const SensorProfile& sensor : lesson.sensors) RequireInRange(sensor, floor_m);
  if (!lesson.sensors.empty()) return;
  WithSettingsKey(lesson.spec, "sensor",
                  [&] { RequireInRange(LoadSensorProfile(lesson.spec.sensor), floor_m); });
}

// Returns the appearance ranges of the scenario. Light settings that the scenario leaves at their
// default are varied nevertheless.
AppearanceRanges LearnedLooks(const AppearanceRanges& of_scenario) {
  const AppearanceRanges fixed = FixedAppearance(), varied;
  AppearanceRanges looks = of_scenario;
  for (Span AppearanceRanges::*span : {&AppearanceRanges::lamp_x_m, &AppearanceRanges::lamp_y_m,
                                       &AppearanceRanges::lamp_z_m, &AppearanceRanges::ambient}) {
    if (looks.*span == fixed.*span) looks.*span = varied.*span;
  }
  return looks;
}

}  // namespace

TrainingLesson PlanTrainingLesson(const LessonChoice& choice) {
  TrainingLesson lesson;
  if (!choice.scenario.scenario.empty()) {
    LoadedScenario loaded = FindScenario(choice.scenario);
    ObjectSet learned;
    for (size_t i = 0; i < loaded.objects.size(); ++i) {
      if (!loaded.spec.objects[i].distractor) learned.push_back(loaded.objects[i]);
    }
    lesson = {loaded.name, std::move(loaded.spec), true, {}, 0, std::move(learned), {}};
  }
  if (!choice.bop_path.empty()) {
    CheckInput(choice.objects.empty() && lesson.objects.empty(),
               "--bop takes the place of OBJECT and --scenario; name one or the other");
    const std::filesystem::path root = choice.bop_path;
    lesson.name = (std::filesystem::absolute(root) / ".")
                      .lexically_normal()
                      .parent_path()
                      .filename()
                      .string();
    lesson.objects = bop::LoadParts(root).objects;
    const auto camera = bop::ReadDatasetCamera(root / "camera.json", bop::ThrowFault);
    if (camera) lesson.camera = camera->intrinsics;
  }
  if (!choice.objects.empty()) {
    const ObjectCatalog catalog = OpenCatalog(choice.scenario.catalog);
    lesson.objects.clear();
    lesson.name.clear();
    for (const std::string& name : choice.objects) {
      lesson.objects.push_back(catalog.Load(name));
      lesson.name += lesson.name.empty() ? name : "-" + name;
    }
  }
  CheckInput(!lesson.objects.empty(),
             "nothing to learn: name objects of the catalog or pass --scenario FILE");
  for (const std::string& name : choice.sensors) {
    lesson.sensors.push_back(LoadSensorProfile(name));
  }
  lesson.distractor_share = choice.distractor_share;
  if (!choice.start_from.empty()) AddKnownParts(choice, lesson);
  if (lesson.has_cell) {
    RequireVisibleParts(lesson);
    RequireFloorInRange(lesson);
  }
  return lesson;
}

std::unique_ptr<LabelledViewSource> MakeTrainingViews(const TrainingLesson& lesson) {
  ViewSourceOptions options;
  options.sensor =
      WithSettingsKey(lesson.spec, "sensor", [&] { return LoadSensorProfile(lesson.spec.sensor); });
  options.pile_sensors = lesson.sensors;
  options.distractor_share = lesson.distractor_share;
  options.looks = LearnedLooks(lesson.spec.appearance);
  options.camera = lesson.camera.value_or(CameraOf(lesson.spec).intrinsics);
  options.bin = BinOf(lesson.spec);
  // The camera of a cell is fixed. But objects are at different heights, and the mounting height
  // varies by about 10 cm.
  const double distance_m = lesson.spec.camera.eye_m.norm();
  options.distance_min_m = kNearest * distance_m;
  options.distance_max_m = kFarthest * distance_m;
  if (!lesson.has_cell) options.for_diameter_m = kUsualDiameter_m;
  return MakeSimViewSource(WithConvexPieces(lesson.objects), options);
}

std::string SensorNames(const TrainingLesson& lesson) {
  if (lesson.sensors.empty()) return lesson.spec.sensor;
  std::vector<std::string> names;
  for (const SensorProfile& sensor : lesson.sensors) names.push_back(sensor.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace pickbed::eval
