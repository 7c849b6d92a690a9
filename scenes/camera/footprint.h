#pragma once

// The region of an image that a bounding box projects to. The renderer uses it to skip objects and
// to limit the drawn area.

#include "scenes/camera/camera.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/image/image.h"

namespace pickbed::scenes {

inline constexpr double kNearestDrawn_m = 0.005;  // nothing nearer to the camera is drawn

// Projection of a box into an image.
struct Footprint {
  double near_m = 0;  // depth of the box's nearest corner, may be negative
  double far_m = 0;   // depth of the box's farthest corner, may be negative
  Eigen::Vector2d min_px = Eigen::Vector2d::Zero();  // only valid if in_front
  Eigen::Vector2d max_px = Eigen::Vector2d::Zero();
  bool in_front = false;  // the complete box is farther than kNearestDrawn_m

  // Returns whether any region of the box may be visible in an image of this camera.
  bool Overlaps(const CameraIntrinsics& k) const;
  // Returns whether the complete box is inside the image.
  bool IsInside(const CameraIntrinsics& k) const;
};

// The rectangle of an image that the included footprints may touch, grown by a pixel for rounding.
class DrawnBox {
 public:
  explicit DrawnBox(const CameraIntrinsics& k) : k_(k), min_(k.width(), k.height()), max_(-1, -1) {}
  void Include(const Footprint& footprint);
  // Only valid after a call of Include().
  ImageBox box() const {
    return {min_.x(), min_.y(), max_.x() - min_.x() + 1, max_.y() - min_.y() + 1};
  }

 private:
  CameraIntrinsics k_;
  Eigen::Vector2i min_, max_;
};

// Projects the eight corners of `bounds_O` into the image of camera `k`.
Footprint FootprintOf(const Bounds& bounds_O, const Pose& X_CO, const CameraIntrinsics& k);

}  // namespace pickbed::scenes
