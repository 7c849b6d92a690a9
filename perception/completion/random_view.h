#pragma once

// Random views of a solid through a depth sensor, for training and tests: pose, distance, floor,
// occlusion and noise.

#include <functional>
#include <string>
#include <vector>

#include "perception/completion/segment_view.h"
#include "perception/completion/viewed_solid.h"
#include "scenes/base/random.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

// Returns the image that a sensor reads instead of the ideal depth image.
using DepthSensor =
    std::function<Image<float>(const Image<float>&, const CameraIntrinsics&, Rng& rng)>;

struct RandomViewOptions {
  double min_distance_m = 0.45;  // of the solid's center
  double max_distance_m = 1.2;
  double max_off_axis = 0.35;   // largest distance of the center from the optical axis, over depth
  double min_diameter_px = 32;  // of the solid's bounding sphere
  double max_diameter_px = 150;
  double occluded_share = 0.5;  // of the views
  double min_hidden = 0.2;      // share of the visible pixels that an occluder hides
  double max_hidden = 0.5;
  double floor_share = 0.5;    // of the views in which the floor is known
  double eroded_share = 0.25;  // of the views whose segment lacks its outermost pixels
  void Visit(SettingsVisitor& v);
};

// A view and its ground truth.
struct RandomView {
  SegmentView view;
  Pose X_CO;
  bool is_occluded = false;
};

// Hides about this share of the pixels of a solid behind a random half plane or disc, which is
// nearer than them. The images have one size. Returns the pixels of the occluder, whose depth is
// set.
Image<uint8_t> DrawOccluder(double hidden, const Image<uint8_t>& solid, Rng& rng,
                            Image<float>& depth_m);

// Draws a view with at least kMinSegmentPixels pixels. It uses one of the sensors; with none, the
// depth is ideal. The result depends only on the arguments and the state of `rng`. Throws
// InputError if no view of the solid has enough pixels.
RandomView DrawView(const ViewedSolid& solid, const std::vector<DepthSensor>& sensors,
                    const RandomViewOptions& options, Rng& rng);

}  // namespace pickbed::perception
