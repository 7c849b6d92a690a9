#pragma once

// Rendered and labelled views of simulated objects, for training data and codebooks.

#include <memory>
#include <vector>

#include "scenes/labelled_view.h"
#include "sim/drop/drop.h"
#include "sim/render/appearance.h"
#include "sim/render/renderer.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::sim {

// Options of the isolated views and of the clutter scenes.
struct ViewSourceOptions {
  SensorProfile sensor;
  // Sensor profiles for views of clutter scenes. Each view draws one at random. Empty = `sensor`.
  std::vector<SensorProfile> scene_sensors;
  // The same for views of rooms, see Surroundings. Profiles that cannot see the scene are left out.
  // Empty = as for other clutter scenes.
  std::vector<SensorProfile> room_sensors;
  CameraIntrinsics camera;       // used for clutter scenes
  double distance_min_m = 0.75;  // distance of the camera to its target on the bin floor
  double distance_max_m = 1.00;
  double tilt_max_rad = 0.35;     // largest angle of the optical axis to the vertical
  double target_jitter_m = 0.03;  // target offset from the floor's center, uniform in x and y
  Bin bin;
  // Above 0: bin, distances and jitter are valid for objects of this diameter. A scaled
  // clutter scene multiplies all three by the mean diameter of its object kinds over this value.
  // 0 = never scaled.
  double for_diameter_m = 0;
  double scaled_share = 0.7;  // share of clutter scenes that are scaled; else 1
  int instances_min = 10;     // instances per clutter scene
  int instances_max = 25;
  double fill_max = 0.6;     // largest share of the bin's volume filled by bounding boxes
  double mixed_share = 0.5;  // share of clutter scenes with several object kinds
  int mixed_kinds_max = 6;   // object kinds per mixed clutter scene
  // Share of clutter scenes that are deep piles. They have this many instances and this share of
  // the bin's volume filled by bounding boxes.
  double deep_share = 0;
  int deep_instances_min = 50;
  int deep_instances_max = 140;
  double deep_fill_max = 1.0;
  // Share of clutter scenes that contain distractors: shapes that are no object of the source
  // (distractors.h). They train an estimator to reject unknown shapes. They are background in
  // `ids`.
  double distractor_share = 0;
  int distractor_max = 6;       // distractors per clutter scene
  bool color = true;            // render color; isolated views are faster without it
  AppearanceRanges appearance;  // lights, materials and backgrounds of color images
  // true = each isolated view gets a random light from `appearance`, placed in a frame at the
  // object with z towards the camera. Otherwise all views share one light beside the camera.
  bool isolated_lamps = false;
  DropOptions drop;
  GlContextOptions gl;
};

// Creates a source that renders the objects and drops them into the bin of the options. Each object
// must have convex pieces. Throws InputError for an empty `objects` or invalid ranges in `options`.
// The source's ClutterScene() throws std::runtime_error if physics fails three times for one seed.
std::unique_ptr<LabelledViewSource> MakeSimViewSource(const ObjectSet& objects,
                                                      const ViewSourceOptions& options);

}  // namespace pickbed::sim
