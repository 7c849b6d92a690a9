#pragma once

// The simulator as a source of labelled views, for training and code books.

#include <memory>
#include <vector>

#include "scenes/labelled_view.h"
#include "sim/appearance.h"
#include "sim/drop.h"
#include "sim/renderer.h"
#include "sim/sensor_profile.h"

namespace pickbed {

struct ViewSourceOptions {
  SensorProfile sensor;
  // Each view of a pile is seen by one of these, drawn at random; empty = by `sensor`.
  std::vector<SensorProfile> pile_sensors;
  CameraIntrinsics camera;       // of piles
  double distance_min_m = 0.75;  // camera to bin centre
  double distance_max_m = 1.00;
  double tilt_max_rad = 0.35;     // of the optical axis from the vertical
  double target_jitter_m = 0.03;  // of the point on the bin's floor that is looked at, x and y
  Bin bin;
  // Above 0: bin, distances and jitter are for parts of this diameter, and piles of other parts get
  // all that in proportion to their mean diameter, as cells are built. Of 0: for any parts.
  double for_diameter_m = 0;
  double scaled_share = 0.7;  // of piles that are so scaled; the others come as they are
  int parts_min = 10;         // of a pile
  int parts_max = 25;
  double fill_max = 0.6;     // share of the bin's volume that the parts' bounding boxes may reach
  double mixed_share = 0.5;  // of piles that mix kinds, where there are several
  int mixed_kinds_max = 6;   // in one pile
  // Of piles in which shapes lie that are no object of the source (foreign_parts.h), for an
  // estimator to learn that not everything is a part; in `ids` they are background.
  double foreign_share = 0;
  int foreign_max = 6;     // of them in one pile
  bool color = true;       // views carry colour; isolated ones are cheaper without
  AppearanceRanges looks;  // of lamps, materials and background, where there is colour
  // Each isolated view has a lamp of its own, by looks in a world that stands at the part with z
  // towards the camera; false = one beside the camera for all.
  bool isolated_lamps = false;
  DropOptions drop;
  GlContextOptions gl;
};

// `objects` must have convex pieces. Throws InputError for no objects or options that leave nothing
// to choose from. Pile() throws std::runtime_error when physics fails three times for a seed.
std::unique_ptr<LabelledViewSource> MakeSimViewSource(const ObjectSet& objects,
                                                      const ViewSourceOptions& options);

}  // namespace pickbed
