#include "scenes/geometry/pose.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "scenes/base/random.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(MakePose, AppliesRotationThenTranslation) {
  const Matrix3d R = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()).matrix();
  const Pose X_AB = MakePose(R, {1, 2, 3});
  EXPECT_TRUE((X_AB * Vector3d(1, 0, 0)).isApprox(Vector3d(1, 3, 3), 1e-12));
  EXPECT_TRUE((Translation({1, 2, 3}) * Vector3d(1, 0, 0)).isApprox(Vector3d(2, 2, 3), 1e-12));
}

TEST(RotationAngle, IsExactFromZeroToPi) {
  Rng rng(1);
  const double pi = std::numbers::pi;
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-3, 1.0, pi / 2, pi - 1e-6, pi - 1e-9, pi}) {
    const Matrix3d R_AB = rng.Rotation().toRotationMatrix();
    const Matrix3d R_AC = R_AB * Eigen::AngleAxisd(angle, rng.UnitVector()).matrix();
    EXPECT_NEAR(RotationAngleRad(R_AB, R_AC), angle, 1e-14 + 1e-15 / (angle + 1e-2)) << angle;
    EXPECT_NEAR(RotationAngleRad(R_AC, R_AB), angle, 1e-14 + 1e-15 / (angle + 1e-2)) << angle;
  }
}

TEST(LookAt, PutsTargetOnTheOpticalAxisAndUpInTheImage) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Vector3d eye = 3 * rng.UnitVector(), target = rng.UnitVector();
    const Pose X_WC = LookAt(eye, target, Vector3d::UnitZ());
    EXPECT_LT((X_WC.linear() * X_WC.linear().transpose() - Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(X_WC.linear().determinant(), 1, 1e-12);
    const Vector3d target_C = X_WC.inverse() * target;
    EXPECT_NEAR(target_C.x(), 0, 1e-12);
    EXPECT_NEAR(target_C.y(), 0, 1e-12);
    EXPECT_NEAR(target_C.z(), (target - eye).norm(), 1e-12);
    // World up points up in the image (y < 0), without a sideways component.
    const Vector3d up_C = X_WC.linear().transpose() * Vector3d::UnitZ();
    EXPECT_LT(up_C.y(), 0);
    EXPECT_NEAR(up_C.x(), 0, 1e-12);
  }
}

TEST(LookAt, RefusesUndefinedViews) {
  const Vector3d up = Vector3d::UnitZ();
  InputErrorOf([&] { LookAt({1, 2, 3}, {1, 2, 3}, up); });
  const std::string message = InputErrorOf([&] { LookAt({0, 0, 1}, {0, 0, 0}, up); });
  EXPECT_NE(message.find("parallel to its up direction"), std::string::npos) << message;
}

TEST(Orthonormalized, RepairsDriftAndReturnsAProperRotation) {
  Rng rng(3);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d R = rng.Rotation().toRotationMatrix();
    EXPECT_LT((Orthonormalized(R) - R).norm(), 1e-12);
    const Matrix3d drifted = 1.01 * R + 1e-4 * rng.Rotation().toRotationMatrix();
    const Matrix3d repaired = Orthonormalized(drifted);
    EXPECT_LT((repaired * repaired.transpose() - Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT((repaired - R).norm(), 1e-3);
    EXPECT_NEAR(Orthonormalized(-R).determinant(), 1, 1e-12);  // never a reflection
  }
}

TEST(ProperRotation, KeepsRotationsAndCorrectsSmallErrors) {
  Rng rng(4);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d R = rng.Rotation().toRotationMatrix();
    EXPECT_EQ(ProperRotation(R, "R"), R) << "not a bit may change";
    const Matrix3d drifted = R + 1e-4 * Matrix3d::Ones();
    const Matrix3d repaired = ProperRotation(drifted, "R");
    EXPECT_LT((repaired * repaired.transpose() - Matrix3d::Identity()).norm(), 1e-12);
  }
}

TEST(ProperRotation, RefusesOtherMatricesWithTheirName) {
  const Matrix3d I = Matrix3d::Identity();
  const auto error = [](const Matrix3d& R) {
    return InputErrorOf([&] { ProperRotation(R, "R_CO"); });
  };
  EXPECT_EQ(error(1.01 * I), "R_CO is no rotation: R^T R differs from the identity by 0.02");
  EXPECT_EQ(error(-I), "R_CO is a reflection: its determinant is -1; negate one column");
  EXPECT_EQ(error(std::numeric_limits<double>::quiet_NaN() * I),
            "R_CO has a value that is not finite");
}

}  // namespace
}  // namespace pickbed::tests
