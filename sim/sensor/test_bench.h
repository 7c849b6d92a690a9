#pragma once

// Test of a sensor profile on surfaces of known shape. It provides a small scene to view, and the
// noise over distance and slant: measured, and predicted by the profile's equations.

#include <vector>

#include "scenes/camera/camera.h"
#include "scenes/image/image.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::sim {

// Returns the test distance of a profile: 1 m, or the nearest distance that is well within its
// range.
double TrialDistance_m(const SensorProfile& profile);

// A frontal wall at the given distance. From left to right it shows a box, a dark and a shiny
// patch, a post, a sphere and four boards. The boards have slants of 30, 50, 70 and 80 degrees.
struct SensorScene {
  CameraIntrinsics camera;
  Image<Rgb8> color;
  Image<float> depth_m;
};
// Makes the scene with its wall at `distance_m` along camera z.
SensorScene MakeSensorScene(double distance_m);

// Noise of the readings at one distance or slant. `axial_m` is the profile's sigma along z.
// `formula_m` also includes lateral jitter on a slope and the step of the reading.
struct NoiseSample {
  double at = 0;  // m or rad
  double measured_m = 0;
  double formula_m = 0;
  double axial_m = 0;
  double lost_share = 0;          // measured share of lost readings
  double lost_formula_share = 0;  // predicted from the profile's probabilities
};
// Measures the noise of a frontal plane over its distance (m).
std::vector<NoiseSample> NoiseByDistance(const SensorProfile& profile);
// Measures the noise of a plane at `distance_m` over its slant (rad).
std::vector<NoiseSample> NoiseBySlant(const SensorProfile& profile, double distance_m);

}  // namespace pickbed::sim
