#include "eval/trial/simulated_cell.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "sim/convex/convex_pieces.h"
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
      appearance_(spec.appearance),
      sensor_(SensorThatSees(spec, camera_)),
      objects_(WithRestingDirections(WithConvexPieces(objects))) {
  CheckSettings("ScenarioSpec", spec);
  drop_.arrangement = ArrangementFromName(spec.arrangement);
  for (const ObjectSpec& object : spec.objects) {
    if (!object.distractor) wanted_.push_back(ObjectId(counts_.size()));
    counts_.push_back(object.count);
  }
}

bool SimulatedCell::IsWanted(ObjectId object) const {
  return std::find(wanted_.begin(), wanted_.end(), object) != wanted_.end();
}

int SimulatedCell::WantedIn(const Scene& scene) const {
  return static_cast<int>(
      std::count_if(scene.objects.begin(), scene.objects.end(),
                    [&](const PosedObject& posed) { return IsWanted(posed.object); }));
}

SceneRenderer& SimulatedCell::renderer() {
  if (!renderer_) renderer_ = std::make_unique<SceneRenderer>(objects_, bin_);
  return *renderer_;
}

CertifiedScene SimulatedCell::MakeScene(BinIndex bin_index) const {
  return pickbed::sim::MakeScene({bin_, objects_, counts_, seed_, bin_index}, drop_);
}

MadeSeries SimulatedCell::MakeSeries(BinIndex bin_index) {
  const SceneRequest request{bin_, objects_, counts_, seed_, bin_index};
  return MakeOcclusionSeries(renderer(), request, wanted_,
                             {objects_, counts_, camera_, drop_, occlusion_});
}

Observation SimulatedCell::Capture(const Scene& scene, BinIndex bin_index, int attempt) {
  RenderedImage image = Render(renderer(), scene, camera_, bin_index, attempt);
  Observation view;
  view.visible_fractions = renderer().VisibleFractions(scene, camera_, image.ids);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    if (!IsWanted(scene.objects[i].object)) view.visible_fractions[i] = 0;
  }
  // Every attempt has its own random stream, so a second image of an unchanged bin is a new sample.
  Rng rng = Rng::Derive(seed_, bin_index, fmt::format("sensor/{}", attempt));
  view.frame.intrinsics = camera_.intrinsics;
  view.frame.depth_m =
      ApplySensorNoise({image.depth_m, camera_.intrinsics, &image.color}, sensor_, rng);
  view.frame.color = std::move(image.color);
  view.ids = std::move(image.ids);
  return view;
}

Image<Rgb8> SimulatedCell::ColorPicture(const Scene& scene, BinIndex bin_index) {
  return Render(renderer(), scene, camera_, bin_index, 0).color;
}

sim::Picture SimulatedCell::PictureOf(const Scene& scene, const Camera& camera,
                                      const sim::PictureOptions& options) {
  if (!pictures_) pictures_ = std::make_unique<sim::PictureRenderer>(renderer(), objects_);
  return pictures_->Render(scene, camera, options);
}

RenderedImage SimulatedCell::Render(SceneRenderer& renderer, const Scene& scene,
                                    const Camera& camera, BinIndex bin_index, int picture) const {
  return RenderWithAppearance(renderer, scene, camera, appearance_, seed_, bin_index, picture);
}

}  // namespace pickbed::eval
