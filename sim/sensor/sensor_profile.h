#pragma once

// Noise model of a depth sensor as data: assets/sensors/NAME.yaml. Each effect has one or a few
// keys. The default of a key disables its effect.
//
// The equations follow two papers. Nguyen, Izadi and Lovell modelled a structured-light camera
// ("Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking", 3DIMPVT 2012).
// Fankhauser et al. modelled a time-of-flight camera ("Kinect v2 for Mobile Robot Navigation:
// Evaluation and Modeling", ICAR 2015). With depth z and slant a (angle between surface normal and
// pixel ray):
//   sigma(z, a)   = c0 + c1 z + c2 z^2 + s z^p a^2 / (pi/2 - a)^2     along z, m
//   lateral(a)    = l0 + l1 a / (pi/2 - a)                            across, px
// Lateral values are pixels of an image with focal length lateral_focal_px. A triangulating camera
// with focal length f and baseline b reads the disparity f b / z in steps. It matches windows
// instead of pixels. So readings closer than correlation_px have similar errors, and a window with
// two surfaces may match neither.

#include <string>
#include <vector>

#include "scenes/base/math.h"
#include "scenes/base/settings.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Parameters of a depth sensor. Symbols refer to the equations above.
struct SensorProfile {
  std::string name = "ideal";
  double min_range_m = 0;
  double max_range_m = 100;

  double axial_floor_m = 0;      // c0, m
  double axial_linear_m = 0;     // c1 at 1 m, m; may be negative if sigma stays >= 0
  double axial_sigma_m = 0;      // c2 at 1 m, m
  double axial_slant_m = 0;      // s at 1 m, m
  double axial_slant_power = 0;  // p, a multiple of 0.5
  double lateral_sigma_px = 0;   // l0, per axis
  double lateral_slant_px = 0;   // l1
  // Errors at this distance have correlation 0.285. At twice the distance, errors and dropout are
  // independent.
  double correlation_px = 0;
  // Focal length of the image in which l0, l1, correlation_px and window_px are measured. 0 = the
  // depth image's focal length.
  double lateral_focal_px = 0;

  double edge_step_m = 0.012;  // an edge has a larger step to a 4-neighbor
  double edge_dropout = 0;     // probability of no reading at an edge
  // The probability falls linearly to 0 at half this distance from the edge, at most 255 pixels of
  // the depth image. 0 = only the edge's own pixels.
  double window_px = 0;
  double random_dropout = 0;     // probability of no reading anywhere
  double grazing_dropout = 0;    // probability of no reading at 90 degrees slant
  double grazing_start_rad = 0;  // it falls linearly to 0 at this slant
  double dark_dropout = 0;       // probability of no reading on black
  double dark_luma = 0.1;        // it falls linearly to 0 at this luma (0 black, 1 white; Rec. 601)
  double shiny_dropout = 0;      // probability of no reading on white
  double shiny_luma = 0.95;  // it falls linearly to 0 at this luma; brighter pixels are highlights
  double flying_share = 0;   // share of edge pixels that read between both surfaces

  double baseline_m = 0;  // position of the projector or second camera along camera x
  // Position of the sensor's own camera along camera x. Not 0 if its depth is registered to the
  // image of another camera.
  double sensor_x_m = 0;
  double disparity_step_px = 0;   // step of the disparity; 0 = none
  double disparity_focal_px = 0;  // focal length of the sensor's own images; 0 = the depth image's
  double quantization_m = 0;      // step of the reading, after the disparity step; 0 = none

  void Visit(SettingsVisitor& v);
  friend bool operator==(const SensorProfile&, const SensorProfile&) = default;
};

// Larger slants are clamped to this value in sigma() and lateral(), which are unbounded at 90
// degrees.
inline constexpr double kSteepestSlant_rad = Radians(85);
// Wider windows are clamped to this width, in pixels of the depth image.
inline constexpr double kWidestWindow_px = 510;

// Returns the standard deviation of the reading along z.
double AxialSigma_m(const SensorProfile& profile, double z_m, double slant_rad);
// Returns the standard deviation of the observed position per axis, in pixels of a depth image with
// this focal length.
double LateralSigma_px(const SensorProfile& profile, double slant_rad, double image_focal_px);
// Returns the number of depth-image pixels per pixel of a lateral_focal_px image.
double LateralScale(const SensorProfile& profile, double image_focal_px);
// Returns correlation_px in depth-image pixels. 0 = pixels have independent errors, also if the
// result is at most one pixel.
double ErrorSpacing_px(const SensorProfile& profile, double image_focal_px);
// Returns window_px in depth-image pixels.
double WindowWidth_px(const SensorProfile& profile, double image_focal_px);
// Returns the distance between projector (or second camera) and the sensor's own camera, m, not
// negative.
double TriangulationBaseline_m(const SensorProfile& profile);
// Returns the distance between two neighboring readings at a depth, for a depth image with this
// focal length.
double ReadingStep_m(const SensorProfile& profile, double z_m, double image_focal_px);

// Returns true if the profile never changes a pixel.
bool ChangesNothing(const SensorProfile& profile);

// Throws InputError if a floor at this depth is out of the sensor's range. Such images would be
// empty without an explanation.
void RequireInRange(const SensorProfile& profile, double floor_m);

std::vector<std::string> SensorProfileNames();  // in assets/sensors, sorted

// Loads a profile. The argument is the NAME of a file in assets/sensors, or a path that ends in
// .yaml. Throws InputError for an unknown name, an invalid value or contradictory values.
SensorProfile LoadSensorProfile(const std::string& name_or_path);

}  // namespace pickbed::sim
