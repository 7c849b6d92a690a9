#pragma once

// Normals and smoothed depth by a plane fit around each pixel.
//
// In a pinhole image the inverse depth of a plane is linear in the pixel, so the fit is a linear
// regression of 1/z on (u, v) and is exact for planes at any slant. Two things keep edges sharp:
// only neighbours in a band of depth around the pixel take part, and where a window beside the
// pixel fits much better than the one around it, which lies across a crease, the pixel takes that
// one's plane (the idea of Kuwahara et al. 1976).

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "scenes/camera.h"
#include "scenes/image.h"

namespace pickbed {

struct PlaneFitOptions {
  int window_px = 5;         // odd, 3..15
  double band_m = 0.010;     // at 1 m, scaled by z
  double min_support = 0.3;  // share of the window that must take part
  // A window beside the pixel must have less than this share of the residual variance of the one
  // around it; near 1 noise chooses, 0 never leaves the middle.
  double side_variance = 0.25;
  // ... and its plane must pass the pixel within so many of its own standard deviations.
  double side_sigmas = 3;
  double min_incidence_cos = 0.1;  // a normal more oblique to the ray than this is not believed
};

// Fits the pixels with mask != 0, from such pixels only. Writes their smoothed depth into `depth_m`
// and their unit normals, towards the camera, into `normals_C` (width * height, zero on entry);
// where the fit is unreliable both stay as they are.
void FitPlanes(const CameraIntrinsics& intrinsics, const Image<uint8_t>& mask,
               const PlaneFitOptions& options, Image<float>& depth_m,
               std::vector<Eigen::Vector3f>& normals_C);

}  // namespace pickbed
