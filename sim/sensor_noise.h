#pragma once

// What a real depth sensor does to ideal depth. Profiles are data: assets/sensors/NAME.yaml.
//
// Axial noise that grows with z^2, lateral jitter and holes at depth edges are the three effects
// that Nguyen, Izadi and Lovell measured on a structured-light camera ("Modeling Kinect Sensor
// Noise for Improved 3D Reconstruction and Tracking", 3DIMPVT 2012).

#include <string>
#include <vector>

#include "scenes/image.h"
#include "scenes/random.h"
#include "scenes/settings.h"

namespace pickbed {

struct SensorProfile {
  std::string name = "ideal";
  double min_range_m = 0;
  double max_range_m = 100;
  double axial_sigma_m = 0;     // at 1 m; grows with z^2
  double lateral_sigma_px = 0;  // jitter of where a pixel looks, of each axis
  double edge_step_m = 0.012;   // a step of more than this to one of 4 neighbours is an edge
  double edge_dropout = 0;      // probability of no reading at an edge
  double random_dropout = 0;    // probability of no reading anywhere
  double quantization_m = 0;    // step of the reading; 0 = none
  void Visit(SettingsVisitor& v);
};

std::vector<std::string> SensorProfileNames();  // of assets/sensors, sorted

// NAME of assets/sensors, or a path ending in .yaml. Throws InputError for an unknown name, a bad
// value, or a range that is empty.
SensorProfile LoadSensorProfile(const std::string& name_or_path);

// Deterministic by the state of `rng`, of which each pixel takes one number. A pixel without ideal
// depth stays without reading; the edge of such a hole is an edge. A pixel that looks past an edge
// reads what is there, so that outlines are ragged; elsewhere it reads between pixels. With a
// profile that changes nothing, the image itself.
Image<float> ApplySensorNoise(const Image<float>& ideal_depth_m, const SensorProfile& profile,
                              Rng& rng);

}  // namespace pickbed
