#pragma once

// What a real depth sensor does to ideal depth. Profiles are data: assets/sensors/NAME.yaml.

#include <filesystem>
#include <string>

#include "scenes/image.h"
#include "scenes/random.h"
#include "scenes/settings.h"

namespace pickbed {

struct SensorProfile {
  std::string name = "ideal";
  double min_range_m = 0;
  double max_range_m = 100;
  double axial_sigma_m = 0;     // at 1 m; grows with z^2
  double lateral_sigma_px = 0;  // jitter of where a pixel looks
  double edge_step_m = 0.012;   // a depth step of more than this is an edge
  double edge_dropout = 0;      // probability of no reading at an edge
  double random_dropout = 0;    // probability of no reading anywhere
  double quantization_m = 0;    // step of the reading; 0 = none
  void Visit(SettingsVisitor& v);
};

// NAME of assets/sensors, or a path ending in .yaml. Throws InputError for an unknown name.
SensorProfile LoadSensorProfile(const std::string& name_or_path);

// Deterministic by the state of `rng`.
Image<float> ApplySensorNoise(const Image<float>& ideal_depth_m, const SensorProfile& profile,
                              Rng& rng);

}  // namespace pickbed
