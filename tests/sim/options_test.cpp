#include <gtest/gtest.h>

#include "sim/drop/drop.h"
#include "sim/drop/occlusion_series.h"
#include "sim/physics/physics_world.h"
#include "sim/render/renderer.h"
#include "sim/sensor/depth_noise.h"
#include "sim/training_view_source.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/planted_option.h"

namespace pickbed::tests {
namespace {

TEST(SimOptions, ValuesOutOfRangeAreRefused) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.1, 0.5)};
  const CameraIntrinsics camera(4, 3, 100, 100, 2, 1);
  const Image<float> depth_m(4, 3, 1.0f);
  Rng rng(0);
  const PlantedOption planted[] = {
      {"rate_hz",
       [] {
         PhysicsOptions options;
         options.rate_hz = kNotANumber;
         PhysicsWorld world(options);
       }},
      {"gravity_W",
       [] {
         PhysicsOptions options;
         options.gravity_W.x() = kNotANumber;
         PhysicsWorld world(options);
       }},
      {"pad.gives_m",
       [] {
         PhysicsOptions options;
         options.pad.gives_m = 0.002;
         PhysicsWorld world(options);
       }},
      {"sleep_after_s",
       [&] {
         DropOptions options;
         options.physics.sleep_after_s = 3;
         DropInstances(Bin(), objects, {1}, rng, options);
       }},
      {"calm_s",
       [&] {
         DropOptions options;
         options.calm_s = kNotANumber;
         DropInstances({}, objects, {1}, rng, options);
       }},
      {"turn_attempts",
       [&] {
         ViewSourceOptions options;
         options.drop.turn_attempts = 0;
         MakeSimViewSource(objects, options);
       }},
      {"max_range_m",
       [&] {
         ViewSourceOptions options;
         options.sensor.max_range_m = kNotANumber;
         MakeSimViewSource(objects, options);
       }},
      {"random_dropout",
       [&] {
         ViewSourceOptions options;
         options.scene_sensors.resize(2);
         options.scene_sensors[1].random_dropout = 1.5;
         MakeSimViewSource(objects, options);
       }},
      {"axial_sigma_m",
       [&] {
         SensorProfile profile;
         profile.axial_sigma_m = kNotANumber;
         ApplySensorNoise({depth_m, camera}, profile, rng);
       }},
      {"margin",
       [&] {
         SceneRenderer renderer(objects, Bin());
         OcclusionSetup setup{objects, {1}, Camera(), {}, {}};
         setup.spec.margin = kNotANumber;
         OccludeTarget(renderer, {{}, {}}, InstanceId{0}, setup, rng);
       }},
      {"bands.1.max",
       [&] {
         SceneRenderer renderer(objects, Bin());
         OcclusionSetup setup{objects, {1}, Camera(), {}, {}};
         setup.spec.bands[1].max = 2;
         MakeOcclusionSeries(renderer, {Bin(), objects, {1}}, {ObjectId{0}}, setup);
       }},
  };
  ExpectRefused(planted);
}

}  // namespace
}  // namespace pickbed::tests
