#pragma once

// Visible Surface Discrepancy: the share of pixels, of those in which the part is seen in its true
// or its estimated pose, where the two surfaces lie apart (Hodan et al., "BOP: Benchmark for 6D
// Object Pose Estimation", ECCV 2018, eq. 1; visibility with missing readings taken as visible, as
// BOP 2019 does).

#include <span>
#include <vector>

#include "scenes/camera.h"
#include "scenes/image.h"

namespace pickbed::bop {

struct VsdOptions {
  double delta_m = 0.015;  // how far behind the measured surface a pixel still counts as visible
};

// Distances from the camera's centre, not depths along its axis.
Image<float> DistancesOf(const Image<float>& depth_m, const CameraIntrinsics& camera);

// A part drawn alone in a pose: its distances within a box of the image.
struct Silhouette {
  int x = 0, y = 0;          // of the box's first pixel
  Image<float> distances_m;  // 0 = not the part; empty = out of view
};
Silhouette SilhouetteOf(const Image<float>& depth_m, const CameraIntrinsics& camera);

// One error in 0..1 for each tolerance `taus`, in diameters. 1 where the part is seen in neither
// pose.
std::vector<double> Vsd(const Silhouette& estimated, const Silhouette& truth,
                        const Image<float>& measured_distances_m, double diameter_m,
                        std::span<const double> taus, const VsdOptions& options = {});

}  // namespace pickbed::bop
