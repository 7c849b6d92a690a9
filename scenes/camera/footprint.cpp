#include "scenes/camera/footprint.h"

#include <algorithm>
#include <limits>

namespace pickbed::scenes {

bool Footprint::Overlaps(const CameraIntrinsics& k) const {
  return far_m > kNearestDrawn_m &&
         (!in_front || (max_px.x() > -0.5 && max_px.y() > -0.5 && min_px.x() < k.width() - 0.5 &&
                        min_px.y() < k.height() - 0.5));
}

bool Footprint::IsInside(const CameraIntrinsics& k) const {
  return in_front && min_px.x() > -0.5 && min_px.y() > -0.5 && max_px.x() < k.width() - 0.5 &&
         max_px.y() < k.height() - 0.5;
}

void DrawnBox::Include(const Footprint& footprint) {
  const Eigen::Vector2d last(k_.width() - 1, k_.height() - 1);
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = last;
  if (footprint.in_front) {
    low = (footprint.min_px.array() - 1).max(0.0).min(last.array()).floor();
    high = (footprint.max_px.array() + 1).max(0.0).min(last.array()).ceil();
  }
  min_ = min_.cwiseMin(low.cast<int>());
  max_ = max_.cwiseMax(high.cast<int>());
}

Footprint FootprintOf(const Bounds& bounds_O, const Pose& X_CO, const CameraIntrinsics& k) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Footprint out;
  out.near_m = kInfinity;
  out.far_m = -kInfinity;
  out.min_px.setConstant(kInfinity);
  out.max_px.setConstant(-kInfinity);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_O((corner & 1 ? bounds_O.max : bounds_O.min).x(),
                              (corner & 2 ? bounds_O.max : bounds_O.min).y(),
                              (corner & 4 ? bounds_O.max : bounds_O.min).z());
    const Eigen::Vector3d p_C = X_CO * p_O;
    out.near_m = std::min(out.near_m, p_C.z());
    out.far_m = std::max(out.far_m, p_C.z());
    const Eigen::Vector2d pixel = Project(k, p_C);
    out.min_px = out.min_px.cwiseMin(pixel);
    out.max_px = out.max_px.cwiseMax(pixel);
  }
  out.in_front = out.near_m > kNearestDrawn_m;
  return out;
}

}  // namespace pickbed::scenes
