#pragma once

// Projection of points to pixel indices, in single precision for inner loops.

#include <Eigen/Core>

#include "perception/layer.h"
#include "scenes/camera/camera.h"

namespace pickbed::perception {

// Pinhole projection with rounding to the nearest pixel.
class Projector {
 public:
  explicit Projector(const CameraIntrinsics& k)
      : fx_(static_cast<float>(k.fx())),
        fy_(static_cast<float>(k.fy())),
        // The half pixel makes truncation round to the nearest pixel center.
        cx_(static_cast<float>(k.cx() + 0.5)),
        cy_(static_cast<float>(k.cy() + 0.5)),
        width_(k.width()),
        height_(k.height()) {}

  // Returns the row-major index of the nearest pixel; -1 outside the image or behind the camera.
  int operator()(const Eigen::Vector3f& p_C) const {
    if (!(p_C.z() > 0)) return -1;
    const float u = fx_ * p_C.x() / p_C.z() + cx_;
    const float v = fy_ * p_C.y() / p_C.z() + cy_;
    // Compared as floats: huge values must not overflow an int. NaN is outside.
    if (!(u >= 0 && v >= 0 && u < width_ && v < height_)) return -1;
    return static_cast<int>(v) * width_ + static_cast<int>(u);
  }

 private:
  float fx_, fy_, cx_, cy_;
  int width_, height_;
};

// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// Returns a box that contains the projection of a ball, clipped to the image. It is empty if the
// ball is outside the image or has no finite center, and the whole image if the camera is inside
// the ball.
PixelBox BallPixels(const CameraIntrinsics& k, const Eigen::Vector3f& center_C, float radius_m);

}  // namespace pickbed::perception
