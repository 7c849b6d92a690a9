#include "perception/rotation_distance.h"

#include <algorithm>
#include <cmath>

namespace pickbed {

RotationDistance::RotationDistance(const SymmetrySet& symmetries_O)
    : ball_(!symmetries_O.continuous_O.empty() && SecondAxis(symmetries_O) != nullptr),
      discrete_O_{Eigen::Matrix3d::Identity()} {
  if (!symmetries_O.continuous_O.empty()) axis_O_ = symmetries_O.continuous_O.front().axis_O;
  for (const Pose& symmetry : symmetries_O.discrete_O) discrete_O_.push_back(symmetry.linear());
}

double RotationDistance::operator()(const Eigen::Matrix3d& R_CO,
                                    const Eigen::Matrix3d& R_CO_other) const {
  if (ball_) return 0;
  const Eigen::Matrix3d between = R_CO.transpose() * R_CO_other;
  if (axis_O_) {
    double largest_cos = -1;
    for (const Eigen::Matrix3d& S : discrete_O_) {
      largest_cos = std::max(largest_cos, axis_O_->dot(between * (S * *axis_O_)));
    }
    return std::acos(std::min(1.0, largest_cos));
  }
  double largest_trace = -1;
  for (const Eigen::Matrix3d& S : discrete_O_) {
    largest_trace = std::max(largest_trace, between.cwiseProduct(S.transpose()).sum());
  }
  return std::acos(std::clamp(0.5 * (largest_trace - 1), -1.0, 1.0));
}

}  // namespace pickbed
