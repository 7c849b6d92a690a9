#pragma once

#include <cmath>

#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::scenes {

// Calls visit(u, v, p_C) for each reading of a depth image, row by row; p_C (m) is the point that
// the pixel (u, v) shows. A reading is positive and finite. With a `stride`, only every stride-th
// row and column is visited, beginning with `first`.
template <typename Visit>
void ForEachDepthPoint(const CameraIntrinsics& k, const Image<float>& depth_m, Visit visit,
                       int stride = 1, int first = 0) {
  for (int v = first; v < depth_m.height(); v += stride) {
    for (int u = first; u < depth_m.width(); u += stride) {
      const float z_m = depth_m(u, v);
      if (z_m > 0 && std::isfinite(z_m)) visit(u, v, BackProject(k, u, v, z_m));
    }
  }
}

}  // namespace pickbed::scenes
