#pragma once

// What a depth sensor does to ideal depth, as data: assets/sensors/NAME.yaml. Each effect is a key
// or a few; at its default it does nothing.
//
// The forms are those of the noise models that Nguyen, Izadi and Lovell fitted to a
// structured-light camera ("Modeling Kinect Sensor Noise for Improved 3D Reconstruction and
// Tracking", 3DIMPVT 2012) and Fankhauser et al. to a time-of-flight camera ("Kinect v2 for Mobile
// Robot Navigation: Evaluation and Modeling", ICAR 2015): with z the depth and a the slant, which
// is the angle between the surface's normal and the ray to the pixel,
//   sigma(z, a)   = c0 + c1 z + c2 z^2 + s z^p a^2 / (pi/2 - a)^2     along z, m
//   lateral(a)    = l0 + l1 a / (pi/2 - a)                            across, px
// of an image of lateral_focal_px, and a triangulating camera with focal length f and baseline b
// reads disparity f b / z in steps. It matches windows, not pixels: readings closer than
// correlation_px err together, and a window that sees two surfaces may match neither.

#include <numbers>
#include <string>
#include <vector>

#include "scenes/settings.h"

namespace pickbed {

struct SensorProfile {
  std::string name = "ideal";
  double min_range_m = 0;
  double max_range_m = 100;

  double axial_floor_m = 0;      // c0
  double axial_linear_m = 0;     // c1 at 1 m; may be negative as long as sigma is not
  double axial_sigma_m = 0;      // c2 at 1 m
  double axial_slant_m = 0;      // s
  double axial_slant_power = 0;  // p, a multiple of 0.5
  double lateral_sigma_px = 0;   // l0, of each axis
  double lateral_slant_px = 0;   // l1
  double correlation_px = 0;     // errors this far apart are alike by 0.285, errors and losses
                                 // twice as far apart independent
  double lateral_focal_px = 0;   // of the images l0, l1, correlation_px and window_px are of; 0 =
                                 // that of the depth image

  double edge_step_m = 0.012;    // a step of more than this to one of 4 neighbours is an edge
  double edge_dropout = 0;       // probability of no reading at an edge, falling linearly
  double window_px = 0;          // to none half of this away from it, at most 255 pixels of the
                                 // depth image; 0 = none beyond the edge's own pixels
  double random_dropout = 0;     // probability of no reading anywhere
  double grazing_dropout = 0;    // probability of no reading at a slant of 90 degrees, falling
  double grazing_start_rad = 0;  // linearly to none at this slant
  double dark_dropout = 0;       // probability of no reading on black, falling linearly
  double dark_luma = 0.1;        // to none at this luma (0 black, 1 white; Rec. 601)
  double shiny_dropout = 0;      // probability of no reading on white, falling linearly
  double shiny_luma = 0.95;      // to none at this luma: what is brighter is taken for a highlight
  double flying_share = 0;       // of edge pixels that read between the two surfaces

  double baseline_m = 0;          // where the projector or second camera stands along camera x
  double sensor_x_m = 0;          // where the sensor's own camera does; not 0 where its depth was
                                  // laid over the image of another one
  double disparity_step_px = 0;   // step of the disparity; 0 = none
  double disparity_focal_px = 0;  // of the sensor's own images; 0 = that of the depth image
  double quantization_m = 0;      // step of the reading, after that of disparity; 0 = none

  void Visit(SettingsVisitor& v);
  friend bool operator==(const SensorProfile&, const SensorProfile&) = default;
};

// Larger slants count as this one in sigma() and lateral(), which have no bound at 90 degrees.
inline constexpr double kSteepestSlant_rad = 85 * std::numbers::pi / 180;
// Wider windows count as this, in pixels of the depth image.
inline constexpr double kWidestWindow_px = 510;

// Standard deviation of the reading along z at a depth and slant.
double AxialSigma_m(const SensorProfile& profile, double z_m, double slant_rad);
// Standard deviation of where a pixel looks, of each axis, in pixels of a depth image of this focal
// length.
double LateralSigma_px(const SensorProfile& profile, double slant_rad, double image_focal_px);
// How many of its pixels are one of lateral_focal_px.
double LateralScale(const SensorProfile& profile, double image_focal_px);
// correlation_px in its pixels; 0 = each of them errs on its own, as where that is no more than
// one.
double ErrorSpacing_px(const SensorProfile& profile, double image_focal_px);
// window_px in its pixels.
double WindowWidth_px(const SensorProfile& profile, double image_focal_px);
// Between projector (or second camera) and the sensor's own camera, m, not negative.
double TriangulationBaseline_m(const SensorProfile& profile);
// The distance between two neighbouring readings at a depth, for a depth image of this focal
// length.
double ReadingStep_m(const SensorProfile& profile, double z_m, double image_focal_px);

// True when no pixel of any image would change.
bool ChangesNothing(const SensorProfile& profile);

// Throws InputError where a floor at this depth is out of its range: nothing else is seen then
// either, and nothing says why.
void RequireInRange(const SensorProfile& profile, double floor_m);

std::vector<std::string> SensorProfileNames();  // of assets/sensors, sorted

// NAME of assets/sensors, or a path ending in .yaml. Throws InputError for an unknown name, a bad
// value, or values that contradict each other.
SensorProfile LoadSensorProfile(const std::string& name_or_path);

}  // namespace pickbed
