#pragma once

// Normal equations of a rigid step about the object center, shared by the ICP variants. They are in
// single precision for inner loops; the pose is in double precision.

#include <Eigen/Core>

#include "perception/icp/icp_result.h"
#include "perception/model/model_points.h"
#include "scenes/geometry/pose.h"

namespace pickbed::perception {

using Matrix6f = Eigen::Matrix<float, 6, 6>;
using Vector6f = Eigen::Matrix<float, 6, 1>;

inline constexpr int kMinIcpPairs = 6;  // the number of unknowns

// Pose as rotation and position of the object center. Rotations about the center keep the normal
// equations well scaled.
struct CenteredPose {
  Eigen::Matrix3d R_CO = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center_C = Eigen::Vector3d::Zero();
};

// Returns the centered form of X_CO.
CenteredPose ToCentered(const Pose& X_CO, const ModelPoints& model);
// Returns X_CO of a centered pose.
Pose ToPose(const CenteredPose& pose, const ModelPoints& model);

// Normal equations of the weighted sum of (direction . (q - p))^2 over the pairs of model point p
// and observed point q. They are stored as moments of the rows (J, residual), in columns of eight
// for vector instructions. Rotations are scaled to motion at the object's radius: `turn` = (p -
// center) x direction / radius.
struct IcpEquations {
  Eigen::Matrix<float, 8, 7> moments = Eigen::Matrix<float, 8, 7>::Zero();
  float sum_squared_m2 = 0;  // unweighted sum of squared residuals
  int pairs = 0;

  // Adds one row with weight root^2. ProjectiveIcp() has the same arithmetic for many rows.
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

// Applies one damped Gauss-Newton step to the pose. `damping` is a share of the mean diagonal
// (Levenberg 1944). Returns kRefined, or leaves the pose and returns the reason:
// kTooFewCorrespondences for fewer than six rows, kStepTooLarge for a step of more than max_step_m,
// beyond which the pairs are no longer valid.
IcpStatus TakeStep(const IcpEquations& equations, double damping, double max_step_m,
                   double radius_m, CenteredPose& pose);

// Returns the reciprocal condition number: smallest over largest eigenvalue of the normal
// equations; 0 = the pose can slide.
double ReciprocalConditionNumber(const IcpEquations& equations);

}  // namespace pickbed::perception
