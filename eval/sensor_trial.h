#pragma once

// A sensor profile put to the test on surfaces of known shape: a small scene to look at, and the
// noise measured against distance and slant beside what the profile's formulas say.

#include <vector>

#include "scenes/camera.h"
#include "scenes/image.h"
#include "sim/sensor_profile.h"

namespace pickbed {

// Distance at which a profile is tried: 1 m, or the nearest that is well within its range.
double TrialDistance_m(const SensorProfile& profile);

// A wall square on at the given distance with, from left to right, a box, a dark and a shiny patch,
// a post, a sphere, and four boards turned by 30, 50, 70 and 80 degrees.
struct SensorScene {
  CameraIntrinsics camera;
  Image<Rgb8> color;
  Image<float> depth_m;
};
SensorScene MakeSensorScene(double distance_m);

// Noise of the readings at one distance or slant. `formula` is the profile's sigma along z together
// with what lateral jitter on a slope and steps of the reading add; `axial` is the first alone.
struct NoiseSample {
  double at = 0;  // m or rad
  double measured_m = 0;
  double formula_m = 0;
  double axial_m = 0;
  double lost_share = 0;          // of readings, measured
  double lost_formula_share = 0;  // by the chances of the profile
};
std::vector<NoiseSample> NoiseByDistance(const SensorProfile& profile);
std::vector<NoiseSample> NoiseBySlant(const SensorProfile& profile, double distance_m);

}  // namespace pickbed
