#include "eval/report/camera_towards.h"

#include <cmath>

#include "scenes/pose.h"

namespace pickbed {

Camera CameraTowards(const Eigen::Vector3d& target, const Eigen::Vector3d& from, double distance_m,
                     int width_px, int height_px, double focal_px) {
  constexpr double kAlongZ = 0.99;
  Camera camera;
  camera.intrinsics = {
      width_px, height_px, focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1)};
  const Eigen::Vector3d direction = from.normalized();
  const Eigen::Vector3d up =
      std::abs(direction.z()) > kAlongZ ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  camera.X_WC = LookAt(target + distance_m * direction, target, up);
  return camera;
}

}  // namespace pickbed
