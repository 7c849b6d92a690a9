#include "perception/cloud/projector.h"

#include <algorithm>
#include <cmath>

namespace pickbed::perception {
namespace {

// Slopes of the two tangent planes of the ball through the camera center, along one image axis. In
// the plane of this axis and z, their angles are center angle -+ asin(r / distance).
struct Interval {
  double low, high;
};

Interval TangentSlopes(double across, double z, double r) {
  const double to_center = std::atan2(across, z);
  const double half = std::asin(std::min(1.0, r / std::hypot(across, z)));
  constexpr double kMax = 1.5;  // rad; beyond it the slope is outside any image
  return {std::tan(std::clamp(to_center - half, -kMax, kMax)),
          std::tan(std::clamp(to_center + half, -kMax, kMax))};
}

}  // namespace

PixelBox BallPixels(const CameraIntrinsics& k, const Eigen::Vector3f& center_C, float radius_m) {
  const Eigen::Vector3d c = center_C.cast<double>();
  if (!c.allFinite() || !(c.z() > -radius_m)) return {};
  if (c.norm() <= radius_m) return {0, 0, k.width(), k.height()};
  const Interval sx = TangentSlopes(c.x(), c.z(), radius_m);
  const Interval sy = TangentSlopes(c.y(), c.z(), radius_m);
  const auto pixel = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  return {pixel(std::floor(k.fx() * sx.low + k.cx()), k.width()),
          pixel(std::floor(k.fy() * sy.low + k.cy()), k.height()),
          pixel(std::ceil(k.fx() * sx.high + k.cx()) + 1, k.width()),
          pixel(std::ceil(k.fy() * sy.high + k.cy()) + 1, k.height())};
}

}  // namespace pickbed::perception
