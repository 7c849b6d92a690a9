#include "grasp/candidates/jaw_wrenches.h"

#include <gtest/gtest.h>

#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

class JawHolds : public testing::Test {
 protected:
  explicit JawHolds(double mass_kg = 0.2) : box_(BoxObject({0.05, 0.05, 0.05}, mass_kg, 0.5)) {}

  std::optional<WrenchSet> Hold(const Pose& X_OG, double opening_m = 0.056, double factor = 1) {
    return JawHold{*box_, hand_, surface_, options_}.At(X_OG, opening_m, factor);
  }

  // True if the contacts balance this force on the center of mass and this moment about it.
  bool Balanced(const WrenchSet& set, const Vector3d& force_n, const Vector3d& torque_nm) {
    Wrench load;
    load << force_n / WrenchForce_n(*box_),
        torque_nm / (WrenchForce_n(*box_) * WrenchRadius_m(*box_));
    return Balances(set, load);
  }

  Rng rng_{1};
  const HandSpec hand_ = SmallJaw().hand;
  RobustOptions options_;
  std::shared_ptr<const ObjectModel> box_;
  SurfacePoints surface_ = SpreadPoints(box_->mesh_O, 0.001, 2000, 20000, rng_);
  // Pads 20 mm wide that cover the center of the box from 15 mm below it to its top.
  const Pose at_center_ = FromAbove({0, 0, -0.015});
};

// Two pads hold 2 * mu * F. A cone with 8 edges gives between cos(22.5 degrees) and 1 times this
// limit.
TEST_F(JawHolds, PullAlongThePadsIsHeldUpToTheFrictionLimit) {
  const auto set = Hold(at_center_);
  ASSERT_TRUE(set);
  const double limit_n = 2 * 0.5 * hand_.force_n;
  const Vector3d pads_center(0, 0, 0.005);
  for (const double side : {1.0, -1.0}) {
    const Vector3d pull_n = side * limit_n * Vector3d::UnitY();
    EXPECT_TRUE(Balanced(*set, 0.88 * pull_n, 0.88 * pads_center.cross(pull_n)));
    EXPECT_FALSE(Balanced(*set, 1.01 * pull_n, 1.01 * pads_center.cross(pull_n)));
  }
  EXPECT_TRUE(Balanced(*set, {0, 0, -0.88 * limit_n}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced(*set, {0, 0, -1.01 * limit_n}, Vector3d::Zero()));
}

TEST_F(JawHolds, FrictionFactorScalesTheLimit) {
  const auto half = Hold(at_center_, 0.056, 0.5);
  ASSERT_TRUE(half);
  const double limit_n = 0.5 * hand_.force_n;
  EXPECT_TRUE(Balanced(*half, {0, 0, -0.88 * limit_n}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced(*half, {0, 0, -1.01 * limit_n}, Vector3d::Zero()));
}

TEST_F(JawHolds, NoWrenchSetIfTheHandHitsOrMissesTheBox) {
  EXPECT_TRUE(Hold(at_center_));
  EXPECT_FALSE(Hold(at_center_, 0.045));  // the fingers would hit its top
  EXPECT_FALSE(Hold(FromAbove({0, 0, 0.030})));
  EXPECT_FALSE(Hold(FromAbove({0.2, 0, -0.015})));
}

// Forces and torques are divided by the weight.
TEST_F(JawHolds, EpsilonIsInverseToTheMass) {
  const auto light = Hold(at_center_);
  box_ = BoxObject({0.05, 0.05, 0.05}, 0.4, 0.5);
  const auto heavy = Hold(at_center_);
  ASSERT_TRUE(light && heavy);
  const WrenchDepthOptions exact{.tolerance = 1e-7};
  EXPECT_NEAR(DepthOfZero(*light, exact).upper, 2 * DepthOfZero(*heavy, exact).upper, 1e-4);
  EXPECT_GT(DepthOfZero(*heavy, exact).lower, 0);
}

TEST_F(JawHolds, RobustnessFallsWithErrorsAndWeight) {
  GraspCandidate centered;
  centered.X_OG = at_center_;
  centered.width_m = 0.05;
  std::vector<GraspCandidate> one{centered};
  const auto robustness = [&](const RobustOptions& options) {
    JudgeJawGrasps(*box_, hand_, SmallJaw().clearance_m, surface_, options, 1, one);
    return one[0].robust;
  };
  RobustOptions options;
  options.position_m = options.rotation_rad = 0.0001;
  EXPECT_EQ(robustness(options), 1);
  options.position_m = 0.01;  // more than the clearance of 3 mm on each side
  EXPECT_LT(robustness(options), 0.5);
  box_ = BoxObject({0.05, 0.05, 0.05}, 5, 0.5);  // heavier than 2 * mu * F holds
  options.position_m = 0.0001;
  EXPECT_EQ(robustness(options), 0);
}

// A loose tolerance gives a lower bound of epsilon within the tolerance.
TEST_F(JawHolds, EpsilonIsRoundedDownWithinTheTolerance) {
  GraspCandidate centered;
  centered.X_OG = at_center_;
  centered.width_m = 0.05;
  const auto epsilon = [&](double tolerance) {
    std::vector<GraspCandidate> one{centered};
    SetJawEpsilon(*box_, hand_, SmallJaw().clearance_m, surface_, {}, one,
                  {.tolerance = tolerance});
    EXPECT_EQ(one[0].robust, centered.robust);
    return one[0].epsilon;
  };
  constexpr double kLoose = 0.3;
  const double exact = epsilon(1e-6), loose = epsilon(kLoose);
  ASSERT_GT(exact, 0);
  EXPECT_LT(loose, (1 - 1e-4) * exact);  // the tolerance is used
  EXPECT_GE(loose, (1 - kLoose) * exact);
}

// The pads hold a bar by friction 2 mu F = 40 N. Gripped beside its center, the weight rotates it
// about the closing axis, against 40 N times the mean lever arm of the patches of 12 to 15 mm.
TEST_F(JawHolds, RobustnessFallsWithTheLeverArmOfTheWeight) {
  box_ = BoxObject({0.05, 0.15, 0.05}, 1.5, 0.5);
  surface_ = SpreadPoints(box_->mesh_O, 0.001, 2000, 40000, rng_);
  RobustOptions options;
  options.position_m = options.rotation_rad = 0.0001;
  std::vector<GraspCandidate> along;
  for (const double aside_m : {0.0, 0.01, 0.06}) {
    GraspCandidate candidate;
    candidate.X_OG = FromAbove({0, aside_m, -0.015});
    candidate.width_m = 0.05;
    along.push_back(candidate);
  }
  JudgeJawGrasps(*box_, hand_, SmallJaw().clearance_m, surface_, options, 1, along);
  EXPECT_EQ(along[0].robust, 1);
  EXPECT_EQ(along[1].robust, 1);
  EXPECT_EQ(along[2].robust, 0);  // 15 N at 60 mm
  EXPECT_GT(along[0].epsilon, along[2].epsilon);
}

// With even pressure, the mean lever arm of a disc is 2/3 of its radius, and of a line a quarter of
// its length.
TEST(JawRim, PointsAreAtTheMeanLeverArm) {
  Rng rng(2);
  PadPatch disc, line;
  for (int i = 0; i < 20000; ++i) {
    const double y = rng.Uniform(-1, 1), z = rng.Uniform(-1, 1);
    if (y * y + z * z < 1) disc.points_G.emplace_back(0.02, 0.006 * y, 0.006 * z - 0.01);
    line.points_G.emplace_back(0.02, 0.010 * rng.Uniform(-1, 1), -0.01);
  }
  const auto mean_distance = [](const std::vector<Vector3d>& rim) {
    double sum = 0;
    for (const Vector3d& p : rim) sum += (p - Vector3d(0.02, 0, -0.01)).norm() / rim.size();
    return sum;
  };
  EXPECT_EQ(RimPoints(disc).size(), 8u);
  EXPECT_NEAR(mean_distance(RimPoints(disc)), 2.0 / 3 * 0.006, 0.0001);
  EXPECT_NEAR(mean_distance(RimPoints(line)), 0.010 / 2, 0.0002);
}

}  // namespace
}  // namespace pickbed::tests
