#include "eval/cell/simulated_cell.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/scenario/object_pool.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/fill_counts.h"
#include "sim/drop/resting_poses.h"
#include "sim/render/appearance.h"
#include "sim/sensor/depth_noise.h"

namespace pickbed::eval {
namespace {

SensorProfile SensorThatSees(const ScenarioSpec& spec, const Camera& camera) {
  return WithSettingsKey(spec, "sensor", [&] {
    SensorProfile sensor = LoadSensorProfile(spec.sensor);
    RequireInRange(sensor, camera.X_CW().translation().z());  // depth of W's origin
    return sensor;
  });
}

}  // namespace

SimulatedCell::SimulatedCell(const ScenarioSpec& spec, const ObjectSet& objects)
    : seed_(spec.seed),
      camera_(CameraOf(spec)),
      bin_(BinOf(spec)),
      occlusion_(spec.occlusion),
      errors_(spec.cell),
      appearance_(spec.appearance),
      sensor_(SensorThatSees(spec, camera_)),
      objects_(objects),
      is_prepared_(objects.size(), false) {
  CheckSettings("ScenarioSpec", spec);
  drop_.arrangement = ArrangementFromName(spec.arrangement);
  entries_ = spec.objects;
  draw_ = spec.draw;
  if (draw_ == 0) PrepareAllObjects();
  for (const ObjectSpec& object : spec.objects) {
    if (!object.distractor) wanted_.push_back(ObjectId(counts_.size()));
    counts_.push_back(object.count);
  }
  counts_place_ = spec.At(spec.fill > 0 ? "fill" : "objects");
  if (spec.fill == 0) return;
  counts_ = WithSettingsKey(
      spec, "fill", [&] { return sim::CountsForFill(bin_, objects_, counts_, spec.fill, drop_); });
}

void SimulatedCell::PrepareAllObjects() const { Prepare(std::vector<int>(objects_.size(), 1)); }

// Prepares the objects with a count over 0.
void SimulatedCell::Prepare(const std::vector<int>& counts) const {
  std::vector<size_t> missing;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0 && !is_prepared_[i]) missing.push_back(i);
  }
  for (size_t k = 0; k < missing.size(); ++k) {
    auto& object = objects_[missing[k]];
    object = WithRestingDirections({WithConvexPieces(object)}).front();
    is_prepared_[missing[k]] = true;
    if (on_prepare_) on_prepare_(static_cast<int>(k + 1), static_cast<int>(missing.size()));
  }
}

std::vector<int> SimulatedCell::CountsIn(BinIndex bin_index) const {
  return draw_ > 0 ? CountsInBin(entries_, draw_, seed_, bin_index) : counts_;
}

void SimulatedCell::SetSeed(uint64_t seed) {
  seed_ = seed;
  drawn_bin_ = BinIndex(-1);  // sizes of another seed deviate differently
}

bool SimulatedCell::IsWanted(ObjectId object) const {
  return std::find(wanted_.begin(), wanted_.end(), object) != wanted_.end();
}

int SimulatedCell::WantedIn(const Scene& scene) const {
  return static_cast<int>(
      std::count_if(scene.objects.begin(), scene.objects.end(),
                    [&](const PosedObject& posed) { return IsWanted(posed.object); }));
}

SimulatedCell::Drawn& SimulatedCell::DrawnIn(BinIndex bin_index) {
  const bool is_other_bin = errors_.size_percent != 0 && drawn_bin_ != bin_index;
  if (!drawn_ || is_other_bin) {
    drawn_ = std::make_unique<Drawn>(TrueObjects(bin_index), bin_);
    drawn_bin_ = bin_index;
  }
  return *drawn_;
}

BinErrors SimulatedCell::ErrorsOf(BinIndex bin_index) const {
  BinErrors errors = DrawBinErrors(errors_, seed_, bin_index);
  if (measures_exactly_) {
    errors.focal = errors.depth_bias_m = errors.depth_scale = 0;
    errors.principal_px.setZero();
  }
  return errors;
}

AttemptErrors SimulatedCell::ErrorsOf(BinIndex bin_index, int attempt) const {
  return DrawAttemptErrors(errors_, seed_, bin_index, attempt);
}

std::vector<double> SimulatedCell::SizesOf(BinIndex bin_index) const {
  return DrawSizes(errors_, seed_, bin_index, objects_.size());
}

ObjectSet SimulatedCell::TrueObjects(BinIndex bin_index) const {
  if (draw_ > 0) Prepare(CountsIn(bin_index));
  return ObjectsOfSizes(objects_, SizesOf(bin_index));
}

void SimulatedCell::AddDeviations(BinIndex bin_index, Scene& scene) const {
  for (PosedObject& posed : scene.objects) {
    posed.deviation = DrawDeviation(errors_, seed_, bin_index, posed.instance);
  }
}

CertifiedScene SimulatedCell::MakeScene(BinIndex bin_index) const {
  const ObjectSet objects = TrueObjects(bin_index);
  const std::vector<int> counts = CountsIn(bin_index);
  // The drop gets only the objects of this bin, because its time steps depend on the smallest one.
  ObjectSet dropped;
  std::vector<int> dropped_counts;
  std::vector<ObjectId> ids;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (counts[i] == 0) continue;
    dropped.push_back(objects[i]);
    dropped_counts.push_back(counts[i]);
    ids.push_back(ObjectId(i));
  }
  CertifiedScene made;
  try {
    made = pickbed::sim::MakeScene({bin_, dropped, dropped_counts, seed_, bin_index}, drop_);
  } catch (const InputError& error) {
    throw InputError(fmt::format(
        "{}: {}{}", counts_place_, error.what(),
        errors_.size_percent > 0 ? ", or lower cell.size_percent, with which objects grow" : ""));
  }
  for (PosedObject& posed : made.scene.objects) posed.object = ids[posed.object];
  AddDeviations(bin_index, made.scene);
  return made;
}

MadeSeries SimulatedCell::MakeSeries(BinIndex bin_index) {
  const ObjectSet objects = TrueObjects(bin_index);
  const SceneRequest request{bin_, objects, counts_, seed_, bin_index};
  MadeSeries made = MakeOcclusionSeries(DrawnIn(bin_index).renderer, request, wanted_,
                                        {objects, counts_, camera_, drop_, occlusion_});
  for (OccludedScene& occluded : made.series.scenes) AddDeviations(bin_index, occluded.scene);
  return made;
}

Observation SimulatedCell::Capture(const Scene& scene, BinIndex bin_index, int attempt) {
  SceneRenderer& renderer = DrawnIn(bin_index).renderer;
  RenderedImage image = Render(renderer, scene, camera_, bin_index, attempt);
  const BinErrors errors = ErrorsOf(bin_index);
  Observation view;
  view.calibration = CalibrationOf(camera_, errors);
  view.visible_fractions = renderer.VisibleFractions(scene, camera_, image.ids);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    if (!IsWanted(scene.objects[i].object)) view.visible_fractions[i] = 0;
  }
  // Every attempt has its own random stream, so a second image of an unchanged bin is a new sample.
  Rng rng = Rng::Derive(seed_, bin_index, fmt::format("sensor/{}", attempt));
  view.frame.intrinsics = view.calibration.camera.intrinsics;
  view.frame.depth_m =
      ApplySensorNoise({image.depth_m, camera_.intrinsics, &image.color}, sensor_, rng);
  AddDepthErrors(errors, view.frame.depth_m);
  view.frame.color = std::move(image.color);
  view.ids = std::move(image.ids);
  return view;
}

Image<Rgb8> SimulatedCell::ColorPicture(const Scene& scene, BinIndex bin_index) {
  return Render(DrawnIn(bin_index).renderer, scene, camera_, bin_index, 0).color;
}

sim::Picture SimulatedCell::PictureOf(const Scene& scene, BinIndex bin_index, const Camera& camera,
                                      const sim::PictureOptions& options) {
  return DrawnIn(bin_index).pictures.Render(scene, camera, options);
}

RenderedImage SimulatedCell::Render(SceneRenderer& renderer, const Scene& scene,
                                    const Camera& camera, BinIndex bin_index, int picture) const {
  return RenderWithAppearance(renderer, scene, camera, appearance_, seed_, bin_index, picture);
}

}  // namespace pickbed::eval
