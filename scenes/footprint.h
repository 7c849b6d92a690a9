#pragma once

// Where a box lands in an image.

#include "scenes/camera.h"
#include "scenes/image.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

inline constexpr double kNearestDrawn_m = 0.005;  // nothing nearer to the camera is drawn

struct Footprint {
  double near_m = 0;  // depth of the box's nearest and farthest corner, may be negative
  double far_m = 0;
  Eigen::Vector2d min_px = Eigen::Vector2d::Zero();  // only meaningful when in_front
  Eigen::Vector2d max_px = Eigen::Vector2d::Zero();
  bool in_front = false;  // all of the box is farther than kNearestDrawn_m

  // May something of the box be drawn in such an image? Is all of it inside?
  bool Overlaps(const CameraIntrinsics& k) const;
  bool IsInside(const CameraIntrinsics& k) const;
};

// The part of an image that footprints may touch, grown by a pixel for rounding.
class DrawnBox {
 public:
  explicit DrawnBox(const CameraIntrinsics& k) : k_(k), min_(k.width, k.height), max_(-1, -1) {}
  void Include(const Footprint& footprint);
  // Once something is included.
  ImageBox box() const {
    return {min_.x(), min_.y(), max_.x() - min_.x() + 1, max_.y() - min_.y() + 1};
  }

 private:
  CameraIntrinsics k_;
  Eigen::Vector2i min_, max_;
};

Footprint FootprintOf(const Bounds& bounds_O, const Pose& X_CO, const CameraIntrinsics& k);

}  // namespace pickbed
