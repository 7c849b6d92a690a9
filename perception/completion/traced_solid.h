#pragma once

// Sphere tracing of solids that are given by signed distances.

#include <functional>
#include <span>

#include "perception/completion/viewed_solid.h"

namespace pickbed::perception {

// Signed distances (m, negative inside) of points (m, in O). Magnitudes may be less than the true
// distance, but not larger. Both arguments have the same size.
using SignedDistances =
    std::function<void(std::span<const Eigen::Vector3f> points_O, std::span<float> distances_m)>;

// A solid that is given by signed distances. Its depth images are sphere traced (Hart 1996) along
// the pixels' perspective rays.
class TracedSolid : public ViewedSolid {
 public:
  TracedSolid(SignedDistances distances_m, const Eigen::AlignedBox3f& box_O)
      : distances_m_(std::move(distances_m)), box_O_(box_O) {}
  Image<float> Depth(const CameraIntrinsics& intrinsics, const Pose& X_CO) const override;
  void Inside(std::span<const Eigen::Vector3f> points_O, std::span<uint8_t> inside) const override;
  float LowestAlong(const Eigen::Vector3f& normal_O) const override;
  Eigen::AlignedBox3f box_O() const override { return box_O_; }

 private:
  SignedDistances distances_m_;
  Eigen::AlignedBox3f box_O_;
};

}  // namespace pickbed::perception
