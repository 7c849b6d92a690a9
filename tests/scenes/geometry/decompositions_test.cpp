#include "scenes/geometry/decompositions.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/random.h"

namespace pickbed::scenes {
namespace {

Eigen::MatrixXd RandomMatrix(int rows, int columns, uint64_t seed) {
  Rng rng(seed);
  Eigen::MatrixXd matrix(rows, columns);
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rows; ++r) matrix(r, c) = rng.Normal();
  }
  return matrix;
}

TEST(Decompositions, EigenvectorsRestoreASymmetricMatrix) {
  const Eigen::MatrixXd half = RandomMatrix(5, 5, 1);
  const Eigen::MatrixXd symmetric = half + half.transpose();
  const SymmetricEigen eigen = EigenOfSymmetric(symmetric);
  EXPECT_TRUE((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose())
                  .isApprox(symmetric, 1e-12));
  EXPECT_TRUE(std::is_sorted(eigen.values.begin(), eigen.values.end()));
}

TEST(Decompositions, EigenvaluesOfABoxInertiaAreItsDiagonal) {
  const Eigen::Matrix3d R = RotationBetween({1, 2, 3}, {-2, 1, 1}).toRotationMatrix();
  const Eigen::Vector3d moments(1, 2, 5);
  const SymmetricEigen3 eigen = EigenOfSymmetric3(R * moments.asDiagonal() * R.transpose());
  EXPECT_TRUE(eigen.values.isApprox(moments, 1e-12));
  EXPECT_NEAR(std::abs(eigen.vectors.col(2).dot(R.col(2))), 1, 1e-12);
}

// The shortest solution of an underdetermined system is perpendicular to the null space.
TEST(Decompositions, MinimumNormSolutionHasNoPartInTheNullSpace) {
  const Eigen::MatrixXd A = RandomMatrix(2, 4, 2);
  const Eigen::Vector2d b(1, -2);
  const Eigen::VectorXd x = MinimumNormSolution(A, b);
  EXPECT_TRUE((A * x).isApprox(b, 1e-12));
  const Eigen::Vector4d any(1, 2, 3, 4);
  const Eigen::Vector4d null = any - MinimumNormSolution(A, A * any);
  EXPECT_LT((A * null).norm(), 1e-12);
  EXPECT_NEAR(null.dot(x), 0, 1e-12);
}

TEST(Decompositions, MinimumNormSolutionIsTheLeastSquaresFitOfAPlane) {
  Eigen::MatrixXd plane(4, 3);
  plane << 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1;
  const Eigen::Vector4d z(0.1, 1.9, 2.9, 5.1);  // 2 x + 3 y, with errors that cancel in the fit
  const Eigen::Vector3d fit = MinimumNormSolution(plane, z);
  EXPECT_TRUE((plane.transpose() * (z - plane * fit)).isZero(1e-12));
  EXPECT_NEAR(fit.x(), 2, 1e-12);
}

TEST(Decompositions, SolvesASymmetricSystem) {
  const Eigen::MatrixXd half = RandomMatrix(6, 6, 3);
  const Eigen::MatrixXd A = half * half.transpose();
  const Eigen::VectorXd x = RandomMatrix(6, 1, 4);
  EXPECT_TRUE(SolveSymmetric(A, A * x).isApprox(x, 1e-8));
}

TEST(Decompositions, RotationBetweenTurnsAboutTheCommonNormal) {
  const Eigen::Vector3d from(1, 0.5, -2), to(0, 3, 1);
  const Eigen::Quaterniond turn = RotationBetween(from, to);
  EXPECT_TRUE((turn * from.normalized()).isApprox(to.normalized(), 1e-12));
  EXPECT_NEAR(turn.vec().dot(from), 0, 1e-12);
  const Eigen::Vector3d opposite = RotationBetween(from, -from) * from;
  EXPECT_TRUE(opposite.isApprox(-from, 1e-12));
}

}  // namespace
}  // namespace pickbed::scenes
