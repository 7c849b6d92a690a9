#include "scenes/geometry/symmetry.h"

#include <gtest/gtest.h>

#include <numbers>

#include "scenes/base/random.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

bool IsIdentity(const Pose& X) { return X.isApprox(Pose::Identity(), 1e-12); }

TEST(SymmetryTransforms, WithoutSymmetryAreOnlyTheIdentity) {
  const SymmetrySet none;
  EXPECT_TRUE(none.trivial());
  const std::vector<Pose> transforms = SymmetryTransforms(none);
  ASSERT_EQ(transforms.size(), 1u);
  EXPECT_TRUE(IsIdentity(transforms[0]));
}

TEST(SymmetryTransforms, BeginWithTheIdentity) {
  const Pose flip = TurnAbout({Vector3d::UnitX(), {0, 0, 0.5}}, std::numbers::pi);
  for (const SymmetrySet& set :
       {SymmetrySet{{flip}, {}}, SymmetrySet{{}, {{Vector3d::UnitZ(), {1, 2, 3}}}},
        SymmetrySet{{flip}, {{Vector3d::UnitZ(), {0, 0, 0}}}},
        SymmetrySet{{}, {{Vector3d::UnitZ(), {0, 0, 0}}, {Vector3d::UnitX(), {0, 0, 0}}}}}) {
    EXPECT_TRUE(IsIdentity(SymmetryTransforms(set, 12).front()));
  }
}

// A cylinder about x at y = 1, z = 2 with ends at x = 0 and 4: each transform maps its surface onto
// itself, and the rotations are evenly spaced.
TEST(SymmetryTransforms, MapACylinderOntoItself) {
  const Vector3d center(2, 1, 2);
  const SymmetrySet set{{TurnAbout({Vector3d::UnitY(), center}, std::numbers::pi)},
                        {{Vector3d::UnitX(), {0, 1, 2}}}};
  constexpr int kSteps = 24;
  const std::vector<Pose> transforms = SymmetryTransforms(set, kSteps);
  ASSERT_EQ(transforms.size(), 2u * kSteps);
  Rng rng(1);
  for (const Pose& S : transforms) {
    EXPECT_NEAR(S.linear().determinant(), 1, 1e-12);
    EXPECT_LT((S * center - center).norm(), 1e-12);
    for (int i = 0; i < 10; ++i) {
      const double angle = rng.Uniform(0, 7), x = rng.Uniform(0, 4);
      const Vector3d q = S * Vector3d(x, 1 + 0.5 * std::cos(angle), 2 + 0.5 * std::sin(angle));
      EXPECT_NEAR((q - Vector3d(q.x(), 1, 2)).norm(), 0.5, 1e-12);
      EXPECT_NEAR(std::abs(q.x() - 2), std::abs(x - 2), 1e-12);
    }
  }
  for (int i = 1; i < kSteps; ++i) {
    EXPECT_NEAR(RotationAngleRad(transforms[i - 1].linear(), transforms[i].linear()),
                2 * std::numbers::pi / kSteps, 1e-12);
  }
  for (size_t i = 0; i < transforms.size(); ++i) {  // all different
    for (size_t j = 0; j < i; ++j) EXPECT_FALSE(transforms[i].isApprox(transforms[j], 1e-9));
  }
}

TEST(SymmetryTransforms, DefaultStepMovesTheSurfaceByOnePercentOfTheDiameter) {
  const std::vector<Pose> rotations = SymmetryTransforms({{}, {{Vector3d::UnitZ(), {0, 0, 0}}}});
  const Vector3d rim(0.5, 0, 0);  // diameter 1
  EXPECT_LE((rotations[1] * rim - rim).norm(), 0.01);
  EXPECT_EQ(rotations.size(), 315);  // as many as the BOP toolkit takes
}

TEST(SymmetryTransforms, BallTransformsCoverAllRotationsAboutItsCenter) {
  const Vector3d center(1, 2, 3);
  const SymmetrySet ball{
      {}, {{Vector3d::UnitZ(), {1, 2, 0}}, {Vector3d(1, 0, 1).normalized(), {2, 2, 4}}}};
  const std::vector<Pose> transforms = SymmetryTransforms(ball, 100);
  EXPECT_LT(transforms.size(), 6000u);
  for (const Pose& S : transforms) EXPECT_LT((S * center - center).norm(), 1e-9);
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d R = rng.Rotation().toRotationMatrix();
    double nearest = 4;
    for (const Pose& S : transforms) nearest = std::min(nearest, RotationAngleRad(R, S.linear()));
    EXPECT_LT(nearest, 0.4);
  }
}

TEST(SymmetryTransforms, TreatsTheSameLineGivenTwiceAsOneAxis) {
  const SymmetrySet twice{{}, {{Vector3d::UnitZ(), {0, 0, 0}}, {-Vector3d::UnitZ(), {0, 0, 5}}}};
  EXPECT_EQ(SymmetryTransforms(twice, 10).size(), 10u);
}

TEST(SymmetryTransforms, RefusesAxesThatDoNotMeet) {
  const ContinuousSymmetry z{Vector3d::UnitZ(), {0, 0, 0}};
  InputErrorOf([&] { SymmetryTransforms({{}, {z, {Vector3d::UnitX(), {0, 0.01, 0}}}}); });
  InputErrorOf([&] { SymmetryTransforms({{}, {z, {Vector3d::UnitZ(), {0.01, 0, 0}}}}); });
  EXPECT_THROW(SymmetryTransforms({{}, {z}}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace pickbed::tests
