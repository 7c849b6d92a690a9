#pragma once

// Failures of real depth cameras beyond a profile: noise that differs between devices, lost areas
// and bands, and depth that is interpolated or smoothed when it is registered to another camera.

#include "scenes/base/random.h"
#include "scenes/image/image.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::sim {

// Returns the profile with random noise, steps and losses: 0.7 to 2 times the axial noise, up to 4
// times the quantization, and more losses at edges and anywhere.
SensorProfile VariedProfile(const SensorProfile& profile, Rng& rng);

// Removes readings in random ellipses and in bands along the image border, and smooths some images
// by a median or a mean of 3 x 3 readings, also across edges. Half of the images stay as they are.
void ApplyFailures(Rng& rng, Image<float>& depth_m);

}  // namespace pickbed::sim
