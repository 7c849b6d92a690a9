#pragma once

// Visible Surface Discrepancy (VSD). It considers the pixels where the object is visible in its
// true or its estimated pose. VSD is the share of them where only one pose is visible, or the two
// surfaces differ by the tolerance or more (Hodan et al., "BOP: Benchmark for 6D Object Pose
// Estimation", ECCV 2018, eq. 1). As in BOP 2019, a pixel without a depth reading counts as
// visible.

#include <span>
#include <vector>

#include "eval/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

struct VsdOptions {
  double delta_m = 0.015;  // a pixel up to this far behind the measured surface is visible
};

// Converts depths along the camera z axis to distances from the camera center, in metres. 0 = no
// reading.
Image<float> DistancesOf(const Image<float>& depth_m, const CameraIntrinsics& camera);

// Rendering of a single object in a pose: its distances within a box of the image.
struct DistanceCrop {
  int x = 0, y = 0;          // image coordinates of the box's first pixel
  Image<float> distances_m;  // 0 = background; empty = object out of view
};
// Crops the rendered depth image of a single object to its bounding box.
DistanceCrop DistanceCropOf(const Image<float>& depth_m, const CameraIntrinsics& camera);

// Returns one error in 0..1 for each tolerance in `taus` (in diameters). The error is 1 if the
// object is visible in neither pose.
std::vector<double> Vsd(const DistanceCrop& estimated, const DistanceCrop& truth,
                        const Image<float>& measured_distances_m, double diameter_m,
                        std::span<const double> taus, const VsdOptions& options = {});

}  // namespace pickbed::eval
