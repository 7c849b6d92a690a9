#include "grasp/candidates/robustness.h"

#include <gtest/gtest.h>

#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

// Returns a wrench set that balances any force along an axis up to `limit` weights, and some
// torque.
WrenchSet WrenchesUpTo(double limit) {
  Wrenches corners(6, 12);
  corners << Eigen::Matrix<double, 6, 6>::Identity(), -Eigen::Matrix<double, 6, 6>::Identity();
  return {{limit * corners}, Wrench::Zero()};
}

RobustOptions NoErrors() {
  RobustOptions options;
  options.samples = 3000;
  options.position_m = options.rotation_rad = options.friction_share = 0;
  options.mass_share = options.com_share = options.tilt_rad = 0;
  return options;
}

double RobustnessOf(const HoldFunction& hold, const RobustOptions& options) {
  return RobustShare(*BoxObject({0.05, 0.05, 0.05}, 0.2), Pose::Identity(), hold, Rng(1), options);
}

TEST(Robust, WithoutErrorsWeightAndLiftDecide) {
  RobustOptions options = NoErrors();
  options.samples = 1;
  options.lift_mps2 = 3;
  const double load = 1 + 3 / kGravity_mps2;
  EXPECT_EQ(RobustnessOf([&](const Pose&, double) { return WrenchesUpTo(1.001 * load); }, options),
            1);
  EXPECT_EQ(RobustnessOf([&](const Pose&, double) { return WrenchesUpTo(0.999 * load); }, options),
            0);
}

// The errors are normal, so the fractions follow the normal distribution. The tolerance of 0.03 is
// over three of their standard deviations.
TEST(Robust, FrictionErrorsFollowTheNormalDistribution) {
  RobustOptions options = NoErrors();
  options.lift_mps2 = 0;
  options.friction_share = 0.2;
  const auto needs = [](double factor) {
    return [factor](const Pose&, double f) { return WrenchesUpTo(f / factor); };
  };
  EXPECT_NEAR(RobustnessOf(needs(1.1), options), 0.3085, 0.03);  // 0.5 sigma above
  EXPECT_NEAR(RobustnessOf(needs(0.8), options), 0.8413, 0.03);  // 1 sigma below
}

TEST(Robust, MassErrorsFollowTheNormalDistribution) {
  RobustOptions options = NoErrors();
  options.lift_mps2 = 0;
  options.mass_share = 0.1;
  const auto limit = [](const Pose&, double) { return WrenchesUpTo(1.1); };
  EXPECT_NEAR(RobustnessOf(limit, options), 0.8413, 0.03);
}

TEST(Robust, PoseErrorsMoveTheHand) {
  RobustOptions options = NoErrors();
  options.position_m = 0.002;
  const auto within = [](const Pose& X_OG, double) -> std::optional<WrenchSet> {
    if (std::abs(X_OG.translation().x()) > 0.002) return std::nullopt;
    return WrenchesUpTo(100);
  };
  EXPECT_NEAR(RobustnessOf(within, options), 0.6827, 0.03);
  options.position_m = 0;
  options.rotation_rad = 0.05;
  const auto upright = [](const Pose& X_OG, double) -> std::optional<WrenchSet> {
    if (RotationAngleRad(X_OG.linear(), Eigen::Matrix3d::Identity()) > 0.05) return std::nullopt;
    return WrenchesUpTo(100);
  };
  EXPECT_NEAR(RobustnessOf(upright, options), 0.6827, 0.03);
}

// A center of mass beside the grasp exerts a torque on it.
TEST(Robust, CenterOfMassErrorsExertTorque) {
  RobustOptions options = NoErrors();
  options.com_share = 0.1;
  const auto stiff = [](const Pose&, double) { return WrenchesUpTo(100); };
  const auto no_torque = [](const Pose&, double) {
    WrenchSet set = WrenchesUpTo(100);
    set.regions[0].bottomRows<3>() *= 1e-6;
    return set;
  };
  EXPECT_EQ(RobustnessOf(stiff, options), 1);
  EXPECT_LT(RobustnessOf(no_torque, options), 0.01);
}

TEST(Robust, SameSeedGivesSameRobustness) {
  RobustOptions options;
  const auto limit = [](const Pose&, double f) { return WrenchesUpTo(1.3 * f); };
  EXPECT_EQ(RobustnessOf(limit, options), RobustnessOf(limit, options));
}

}  // namespace
}  // namespace pickbed::tests
