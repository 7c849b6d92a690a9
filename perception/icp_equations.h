#pragma once

// What ICP variants share: normal equations of a rigid step about the part's centre. For inner
// loops; single precision but for the pose itself.

#include <Eigen/Core>

#include "perception/model_points.h"
#include "scenes/pose.h"

namespace pickbed {

using Matrix6f = Eigen::Matrix<float, 6, 6>;
using Vector6f = Eigen::Matrix<float, 6, 1>;

inline constexpr int kMinIcpPairs = 6;  // as many as unknowns

// Pose by rotation and the place of the part's centre: turns about the centre keep the normal
// equations well scaled.
struct CenteredPose {
  Eigen::Matrix3d R_CO = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center_C = Eigen::Vector3d::Zero();
};

CenteredPose ToCentered(const Pose& X_CO, const ModelPoints& model);
Pose ToPose(const CenteredPose& pose, const ModelPoints& model);

// Normal equations of the weighted sum of (direction . (q - p))^2 over the pairs: the moments of
// rows (J, residual), in columns of eight for the sake of vector instructions. A turn counts as
// motion at the part's radius: `turn` = (p - centre) x direction / radius.
struct IcpEquations {
  Eigen::Matrix<float, 8, 7> moments = Eigen::Matrix<float, 8, 7>::Zero();
  float sum_squared_m2 = 0;  // not weighted
  int pairs = 0;

  // The row counts with weight root^2.
  void Add(const Eigen::Vector3f& turn, const Eigen::Vector3f& direction, float residual_m,
           float root) {
    Eigen::Matrix<float, 8, 1> row;
    row << turn, direction, residual_m, 0;
    row *= root;
    for (int i = 0; i < 7; ++i) moments.col(i) += row[i] * row;
    sum_squared_m2 += residual_m * residual_m;
    ++pairs;
  }
  Matrix6f hessian() const { return moments.topLeftCorner<6, 6>(); }
  Vector6f gradient() const { return moments.col(6).head<6>(); }
};

// One damped Gauss-Newton step; `damping` is a share of the mean of the diagonal (Levenberg 1944).
// False and no step where fewer than six rows hold or the step is longer than max_step_m, after
// which the pairs mean nothing.
bool TakeStep(const IcpEquations& equations, double damping, double max_step_m, double radius_m,
              CenteredPose& pose);

// Smallest over largest eigenvalue of the normal equations; 0 = slides.
double Conditioning(const IcpEquations& equations);

}  // namespace pickbed
