#pragma once

// Matrix decompositions. The compiler needs seconds for each of Eigen's, so that only one source
// contains them. Small matrices and vectors of all sizes are accepted.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace pickbed::scenes {

// Eigenvalues in ascending order, and the eigenvectors (columns, of length 1) that belong to them.
struct SymmetricEigen3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

// Returns eigenvalues and eigenvectors of a symmetric matrix. Only its lower triangle is read.
SymmetricEigen3 EigenOfSymmetric3(const Eigen::Matrix3d& symmetric);
SymmetricEigen EigenOfSymmetric(const Eigen::MatrixXd& symmetric);

// Returns the shortest vector x that minimizes |A x - b|. A may have any rank.
Eigen::VectorXd MinimumNormSolution(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                    const Eigen::VectorXd& b);

// Returns the x that solves A x = b. A is symmetric and positive (semi)definite.
Eigen::VectorXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::VectorXd& b);

// Returns the shortest rotation from one direction to the other. For opposite directions it is a
// half turn about some perpendicular axis. A direction of length 0 gives no rotation.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace pickbed::scenes
