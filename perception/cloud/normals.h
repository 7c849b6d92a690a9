#pragma once

// Normals and smoothed depth from a plane fit around each pixel.
//
// In a pinhole image the inverse depth of a plane is linear in the pixel coordinates. The fit is a
// linear regression of 1/z on (u, v), which is exact for planes at any slant. Two rules keep edges
// sharp. Only neighbours within a depth band around the pixel take part. If the window around the
// pixel crosses a crease, a window beside it fits much better. The pixel then takes the plane of
// that window (the idea of Kuwahara et al. 1976).

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "perception/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::perception {

struct PlaneFitOptions {
  int window_px = 5;         // odd, 3..15
  double band_m = 0.010;     // half width of the depth band at 1 m, scaled by z
  double min_support = 0.3;  // minimum share of the window that takes part
  // A side window replaces the center window if its residual variance is below this share of the
  // center's. Near 1, noise decides; at 0, the center window is always used.
  double side_variance = 0.25;
  // The plane of a side window must also pass the pixel within this many of its standard
  // deviations.
  double side_sigmas = 3;
  double min_incidence_cos = 0.1;  // normals more oblique to the viewing ray are rejected
};

// Fits a plane at each pixel with mask != 0, from such pixels only. Writes the smoothed depth into
// `depth_m` and unit normals towards the camera into `normals_C` (width * height). Where there is
// no reliable fit, the depth keeps its value and the normal is zero. The result is the same for any
// number of threads.
void FitPlanes(const CameraIntrinsics& intrinsics, const Image<uint8_t>& mask,
               const PlaneFitOptions& options, Image<float>& depth_m,
               std::vector<Eigen::Vector3f>& normals_C, int threads = 1);

}  // namespace pickbed::perception
