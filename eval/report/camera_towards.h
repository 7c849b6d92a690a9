#pragma once

// Cameras for pictures of single parts.

#include <Eigen/Core>

#include "scenes/camera.h"

namespace pickbed {

// Looks at `target` from the direction `from` (of any length) at a distance, z of the world up; y
// where it looks along z. Square pixels, the principal point in the middle.
Camera CameraTowards(const Eigen::Vector3d& target, const Eigen::Vector3d& from, double distance_m,
                     int width_px, int height_px, double focal_px);

}  // namespace pickbed
