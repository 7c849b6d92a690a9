#pragma once

// A solid of known shape that can be seen by a camera: the source of training and test views.

#include <cstdint>
#include <span>

#include "perception/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"

namespace pickbed::perception {

class ViewedSolid {
 public:
  virtual ~ViewedSolid() = default;
  // Returns the ideal depth image of the solid: m along camera z, 0 = the pixel misses it. The
  // complete solid must be before the camera.
  virtual Image<float> Depth(const CameraIntrinsics& intrinsics, const Pose& X_CO) const = 0;
  // Sets `inside` to 1 for the points (m, in O) inside the solid, else to 0. Both have the same
  // size.
  virtual void Inside(std::span<const Eigen::Vector3f> points_O,
                      std::span<uint8_t> inside) const = 0;
  // Returns the smallest normal . p over the solid's points, m. `normal_O` has unit length.
  virtual float LowestAlong(const Eigen::Vector3f& normal_O) const = 0;
  virtual Eigen::AlignedBox3f box_O() const = 0;  // bounding box, m
};

}  // namespace pickbed::perception
