#include "perception/training/logit_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scenes/base/random.h"

namespace pickbed::tests {
namespace {

// An overconfident verifier: Newton's whole steps would diverge to scales of thousands.
TEST(Calibrate, EqualLogitsGetTheirShareOfRightPoses) {
  std::vector<ScoredPose> poses;
  for (int i = 0; i < 1030; ++i) poses.push_back({6.0, i < 1000});
  for (int i = 0; i < 2000; ++i) poses.push_back({-6.0, false});
  const Calibration calibration = Calibrate(poses);
  const auto probability = [&](double logit) {
    return 1 / (1 + std::exp(-calibration.scale * logit - calibration.shift));
  };
  EXPECT_NEAR(probability(6), 1000.0 / 1030, 0.003);
  EXPECT_LT(probability(-6), 0.005);
  EXPECT_LT(calibration.scale, 3);
}

// The best scale would be negative, so it stays at its limit and the shift has to lower the scores.
TEST(Calibrate, SureButWrongPosesGetLowScores) {
  const Calibration calibration = Calibrate(std::vector<ScoredPose>(24, {12.0, false}));
  EXPECT_NEAR(calibration.scale, 0.2, 1e-6);
  const double logit = calibration.scale * 12 + calibration.shift;
  // At the minimum, the slope of the loss along the shift is zero; the prior counts as two poses.
  EXPECT_NEAR(24 / (1 + std::exp(-logit)) + 2 * calibration.shift, 0, 1e-3);
  EXPECT_LT(logit, -0.5);
}

// Poses are right with P = 1 / (1 + exp(-(2 logit + 1))), while the score claims 1 / (1 +
// exp(-logit)).
TEST(Calibrate, FindsAPlantedRule) {
  Rng rng(3);
  std::vector<ScoredPose> poses(4000);
  for (ScoredPose& pose : poses) {
    pose.logit = rng.Uniform(-3, 3);
    pose.right = rng.Uniform() < 1 / (1 + std::exp(-(2 * pose.logit + 1)));
  }
  const Calibration found = Calibrate(poses), untouched = Calibrate({});
  EXPECT_NEAR(found.scale, 2, 0.2);
  EXPECT_NEAR(found.shift, 1, 0.2);
  EXPECT_EQ(untouched.scale, 1);
  EXPECT_EQ(untouched.shift, 0);
}

}  // namespace
}  // namespace pickbed::tests
