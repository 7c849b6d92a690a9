#include "scenes/geometry/pose.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::scenes {

Pose MakePose(const Eigen::Matrix3d& R_AB, const Eigen::Vector3d& p_AB) {
  Pose X_AB = Pose::Identity();
  X_AB.linear() = R_AB;
  X_AB.translation() = p_AB;
  return X_AB;
}

Pose Translation(const Eigen::Vector3d& p_AB) {
  return MakePose(Eigen::Matrix3d::Identity(), p_AB);
}

double RotationAngleRad(const Eigen::Matrix3d& R_AB, const Eigen::Matrix3d& R_AC) {
  const Eigen::Matrix3d R_BC = R_AB.transpose() * R_AC;
  // Sine and cosine are both used, because the arc cosine loses half of the digits near 0 and pi.
  const Eigen::Vector3d twice_sin_axis(R_BC(2, 1) - R_BC(1, 2), R_BC(0, 2) - R_BC(2, 0),
                                       R_BC(1, 0) - R_BC(0, 1));
  return std::atan2(twice_sin_axis.norm(), R_BC.trace() - 1);
}

Pose LookAt(const Eigen::Vector3d& eye_W, const Eigen::Vector3d& target_W,
            const Eigen::Vector3d& up_W) {
  constexpr double kSmall = 1e-9;  // below this length the direction is rounding noise
  const Eigen::Vector3d view_W = target_W - eye_W;
  CheckInput(view_W.norm() > kSmall,
             "the camera position and its target are the same point; move the eye or the target");
  const Eigen::Vector3d z_W = view_W.normalized();
  const Eigen::Vector3d down_W = z_W.dot(up_W) * z_W - up_W;
  CheckInput(down_W.norm() > kSmall * up_W.norm(),
             "the camera's viewing direction is parallel to its up direction; choose another up "
             "direction");
  const Eigen::Vector3d y_W = down_W.normalized();
  Eigen::Matrix3d R_WC;
  R_WC << y_W.cross(z_W), y_W, z_W;
  return MakePose(R_WC, eye_W);
}

Eigen::Matrix3d Orthonormalized(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d ProperRotation(const Eigen::Matrix3d& R, const std::string& name) {
  constexpr double kExact = 1e-9;
  CheckInput(R.allFinite(), name + " has a value that is not finite");
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  CheckInput(
      error <= kMaxRotationError,
      fmt::format("{} is no rotation: R^T R differs from the identity by {:.2g}", name, error));
  CheckInput(R.determinant() > 0,
             fmt::format("{} is a reflection: its determinant is -1; negate one column", name));
  return error < kExact ? R : Orthonormalized(R);
}

}  // namespace pickbed::scenes
