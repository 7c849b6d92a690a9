#pragma once

// Sensor simulation: adds the noise and dropout of a SensorProfile to an ideal depth image.

#include "scenes/base/random.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::sim {

// Ideal input of the sensor. Slants are computed from depth and intrinsics.
struct IdealView {
  const Image<float>& depth_m;
  const CameraIntrinsics& intrinsics;
  const Image<Rgb8>* color = nullptr;  // null or empty: no surface is dark or shiny
};

// Returns the depth image that the sensor would read. The result depends only on the inputs and the
// state of `rng`, which is advanced by one number. A pixel's noise depends only on this number and
// the pixel's position. A profile that changes nothing returns the input image.
//
// A pixel without ideal depth has no reading, and the border of such a hole is an edge. A displaced
// pixel beyond an edge reads the surface there, which makes outlines ragged; elsewhere it reads
// interpolated depth. Probabilities of a reading multiply. The order of effects is: dropout,
// displacement (or flying pixel), noise, quantization, range limits.
//
// Throws InputError if the sizes of depth, intrinsics and color differ, and for a profile with
// values out of range.
Image<float> ApplySensorNoise(const IdealView& view, const SensorProfile& profile, Rng& rng);

}  // namespace pickbed::sim
