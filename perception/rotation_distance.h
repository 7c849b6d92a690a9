#pragma once

// Angle between two orientations of a part, the least over its symmetries: what a look-up of whole
// views can get right at best.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "scenes/symmetry.h"

namespace pickbed {

class RotationDistance {
 public:
  explicit RotationDistance(const SymmetrySet& symmetries_O);

  // In [0, pi]. Turns about a continuous axis count for nothing, so that the angle is the one
  // between the axes; for a ball it is 0.
  double operator()(const Eigen::Matrix3d& R_CO, const Eigen::Matrix3d& R_CO_other) const;

 private:
  bool ball_ = false;
  std::optional<Eigen::Vector3d> axis_O_;
  std::vector<Eigen::Matrix3d> discrete_O_;  // identity first
};

}  // namespace pickbed
