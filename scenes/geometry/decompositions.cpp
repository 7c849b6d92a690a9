#include "scenes/geometry/decompositions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace pickbed::scenes {

SymmetricEigen3 EigenOfSymmetric3(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen EigenOfSymmetric(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd MinimumNormSolution(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                    const Eigen::VectorXd& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}

Eigen::VectorXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::VectorXd& b) {
  return A.ldlt().solve(b);
}

Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  if (!(from.norm() > 0 && to.norm() > 0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace pickbed::scenes
