#include "perception/model/pose_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes/base/random.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

Pose RandomPose(Rng& rng) {
  return MakePose(rng.Rotation().toRotationMatrix(), 0.1 * rng.UnitVector());
}

Pose HalfTurn(const Eigen::Vector3d& axis) {
  return MakePose(Eigen::AngleAxisd(std::numbers::pi, axis).toRotationMatrix(),
                  Eigen::Vector3d::Zero());
}

TEST(PoseEmbedding, ShiftDistanceIsLengthOverDiameter) {
  const auto object = ObjectOf(BoxMesh({0.06, 0.04, 0.02}, Eigen::Vector3d::Zero()));
  const PoseEmbedding embedding(*object);
  Rng rng(1);
  const Pose X = RandomPose(rng);
  EXPECT_NEAR(embedding.Distance(X, Translation({0.003, 0, 0.004}) * X), 0.005 / object->diameter_m,
              1e-5);
}

TEST(PoseEmbedding, RotationDistanceIsTheChordOfTheCorners) {
  // The corners of a cube of side a are a / sqrt(2) from the z axis and move by 2 r sin(angle / 2).
  const auto object = ObjectOf(BoxMesh({0.04, 0.04, 0.04}, Eigen::Vector3d::Zero()));
  const PoseEmbedding embedding(*object);
  const Pose rotation = MakePose(
      Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), Eigen::Vector3d::Zero());
  EXPECT_NEAR(embedding.Distance(Pose::Identity(), rotation),
              2 * 0.04 / std::sqrt(2.0) * std::sin(0.15) / object->diameter_m, 1e-5);
}

TEST(PoseEmbedding, LeverageBoundsTheMotionOfAPoint) {
  const Eigen::Vector3d center(0.01, 0, -0.02), corner(0.02, 0.02, 0.02);
  const auto cube = ObjectOf(BoxMesh({0.04, 0.04, 0.04}, center));
  const PoseEmbedding of_cube(*cube);
  EXPECT_NEAR(of_cube.Leverage(center), 1, 1e-9);
  EXPECT_NEAR(of_cube.Leverage(center + corner), 2, 1e-9);
  const auto object = ObjectOf(BracketMesh());
  const PoseEmbedding embedding(*object);
  const Eigen::Vector3d p_O = object->mass.com_O;
  const double leverage = embedding.Leverage(p_O);
  double largest = 0;
  Rng rng(4);
  for (int i = 0; i < 2000; ++i) {
    const Pose X = RandomPose(rng), Y = RandomPose(rng);
    const double share = (X * p_O - Y * p_O).norm() / object->diameter_m / embedding.Distance(X, Y);
    ASSERT_LE(share, leverage + 1e-5);
    largest = std::max(largest, share);
  }
  EXPECT_GT(largest, 0.8 * leverage) << "no tighter bound holds";
}

// All key points are on the axis.
TEST(PoseEmbedding, LeverageOnASymmetryAxis) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const auto rod = ObjectOf(BoxMesh({0.02, 0.02, 0.1}, Eigen::Vector3d::Zero()),
                            {{}, {{z, Eigen::Vector3d::Zero()}}});
  const PoseEmbedding embedding(*rod);
  EXPECT_NEAR(embedding.Leverage(Eigen::Vector3d::Zero()), 1, 1e-6);
  EXPECT_NEAR(embedding.Leverage({0, 0, 0.05}), std::sqrt(2.0), 1e-6);
}

TEST(PoseEmbedding, DistanceIsSymmetricAndFrameInvariant) {
  const auto object = ObjectOf(BracketMesh(), {{HalfTurn(Eigen::Vector3d::UnitX())}, {}});
  const PoseEmbedding embedding(*object);
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Pose a = RandomPose(rng), b = RandomPose(rng), move = RandomPose(rng);
    EXPECT_NEAR(embedding.Distance(a, b), embedding.Distance(b, a), 1e-5);
    EXPECT_NEAR(embedding.Distance(a, b), embedding.Distance(move * a, move * b), 1e-5);
  }
}

TEST(PoseEmbedding, SymmetricPosesHaveZeroDistance) {
  const Pose half_turn = HalfTurn(Eigen::Vector3d::UnitY());
  const auto object =
      ObjectOf(BoxMesh({0.06, 0.04, 0.02}, Eigen::Vector3d::Zero()), {{half_turn}, {}});
  const PoseEmbedding embedding(*object);
  Rng rng(3);
  const Pose X = RandomPose(rng);
  EXPECT_EQ(embedding.variants(), 2);
  EXPECT_NEAR(embedding.Distance(X, X * half_turn), 0, 1e-5);
  EXPECT_GT(embedding.Distance(X, X * HalfTurn(Eigen::Vector3d::UnitX())), 0.3);
}

TEST(PoseEmbedding, SymmetryAxisRotationsHaveZeroDistance) {
  const auto object =
      ObjectOf(BoxMesh({0.02, 0.02, 0.08}, Eigen::Vector3d::Zero()), {{}, {ContinuousSymmetry{}}});
  const PoseEmbedding embedding(*object);
  Rng rng(4);
  const Pose X = RandomPose(rng);
  const Pose rotation = MakePose(
      Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()).toRotationMatrix(), Eigen::Vector3d::Zero());
  EXPECT_NEAR(embedding.Distance(X, X * rotation), 0, 1e-5);
  EXPECT_GT(embedding.Distance(X, X * HalfTurn(Eigen::Vector3d::UnitX())), 0.5);
}

}  // namespace
}  // namespace pickbed::tests
