#include "perception/icp/normal_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace pickbed::perception {

CenteredPose ToCentered(const Pose& X_CO, const ModelPoints& model) {
  return {X_CO.linear(), X_CO * model.center_O.cast<double>()};
}

Pose ToPose(const CenteredPose& pose, const ModelPoints& model) {
  Pose X_CO = Pose::Identity();
  X_CO.linear() = Eigen::Quaterniond(pose.R_CO).normalized().toRotationMatrix();
  X_CO.translation() = pose.center_C - X_CO.linear() * model.center_O.cast<double>();
  return X_CO;
}

IcpStatus TakeStep(const IcpEquations& equations, double damping, double max_step_m,
                   double radius_m, CenteredPose& pose) {
  if (equations.pairs < kMinIcpPairs) return IcpStatus::kTooFewCorrespondences;
  Matrix6f hessian = equations.hessian();
  hessian.diagonal().array() += static_cast<float>(damping) * hessian.trace() / 6;
  const Vector6f x = hessian.ldlt().solve(equations.gradient());
  const Eigen::Vector3d turn = x.head<3>().cast<double>() / radius_m;
  const Eigen::Vector3d move = x.tail<3>().cast<double>();
  if (!(move.norm() + turn.norm() * radius_m < max_step_m)) return IcpStatus::kStepTooLarge;
  const double angle = turn.norm();
  if (angle > 0) pose.R_CO = Eigen::AngleAxisd(angle, turn / angle) * pose.R_CO;
  pose.center_C += move;
  return IcpStatus::kRefined;
}

double ReciprocalConditionNumber(const IcpEquations& equations) {
  const Eigen::SelfAdjointEigenSolver<Matrix6f> solver(equations.hessian(), Eigen::EigenvaluesOnly);
  const float largest = solver.eigenvalues()[5];
  return largest > 0 ? std::max(0.0f, solver.eigenvalues()[0]) / largest : 0.0;
}

}  // namespace pickbed::perception
