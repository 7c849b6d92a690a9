#pragma once

// Ideal depth as a real sensor would read it, by a SensorProfile.

#include "scenes/camera.h"
#include "scenes/image.h"
#include "scenes/random.h"
#include "sim/sensor_profile.h"

namespace pickbed {

// What there is to be seen. Slants follow from the depth image and the intrinsics.
struct IdealView {
  const Image<float>& depth_m;
  const CameraIntrinsics& intrinsics;
  const Image<Rgb8>* color = nullptr;  // null or empty: no surface counts as dark or shiny
};

// Deterministic by the state of `rng`, of which it takes one number: what a pixel gets depends on
// that number and the pixel's place alone. With a profile that changes nothing, the image itself.
//
// A pixel without ideal depth stays without reading; the edge of such a hole is an edge. A pixel
// that looks past an edge reads what is there, so that outlines are ragged; elsewhere it reads
// between pixels. Chances of having no reading multiply. A reading is lost first, then displaced
// (or flying), then noisy, then quantised, then cut by the range.
//
// Throws InputError when the sizes of depth, intrinsics and colour differ.
Image<float> ApplySensorNoise(const IdealView& view, const SensorProfile& profile, Rng& rng);

}  // namespace pickbed
