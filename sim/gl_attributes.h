#pragma once

// From poses and cameras to what the vertex shader takes.

#include "scenes/footprint.h"
#include "sim/gl_objects.h"
#include "sim/renderer.h"

namespace pickbed {

struct DepthRange {
  double near_m = std::numeric_limits<double>::infinity();
  double far_m = 0;

  void Include(const Footprint& footprint) {
    near_m = std::min(near_m, std::max(kNearestDrawn_m, 0.999 * footprint.near_m));
    far_m = std::max(far_m, 1.001 * footprint.far_m);
  }
};

// For an image whose first pixel is `corner` of a viewport of this size.
InstanceAttributes AttributesOf(const Pose& X_CO, const RenderInstance& instance,
                                const CameraIntrinsics& k, const DepthRange& range,
                                const Eigen::Vector2i& corner, int viewport_width,
                                int viewport_height);

}  // namespace pickbed
