#include "grasp/place/hand_motion.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

TEST(HandMotion, LiftMovesAsideFirstAndThenStraightUp) {
  const Eigen::Vector2d aside_m(0.03, -0.01);
  EXPECT_TRUE(LiftMotion(aside_m, 0).isZero());
  EXPECT_TRUE(LiftMotion(aside_m, 0.12).isApprox(Vector3d(0.03, -0.01, 0.12)));
  EXPECT_TRUE(LiftMotion(aside_m, 0.3).isApprox(Vector3d(0.03, -0.01, 0.3)));
  EXPECT_EQ(LiftMotion({0, 0}, 0.05), Vector3d(0, 0, 0.05));
}

// The horizontal speed per height falls steadily to zero, so that the object feels no jerk.
TEST(HandMotion, ShiftOfALiftSlowsDownSteadily) {
  const double step_m = 0.001;
  double last = 2 * 0.03 / 0.12;
  for (int i = 0; i < 150; ++i) {
    const auto x_m = [&](int k) { return LiftMotion({0.03, 0}, k * step_m).x(); };
    const double slope = (x_m(i + 1) - x_m(i)) / step_m;
    EXPECT_LE(slope, last + 1e-9) << i;
    EXPECT_GT(slope, last - 0.006) << i;
    last = slope;
  }
  EXPECT_EQ(last, 0);
}

TEST(HandMotion, PeakSpeedOfMinimumJerkIsAsAsked) {
  const double distance_m = 0.4, peak_mps = 0.5;
  const double duration_s = MinimumJerkSeconds(distance_m, peak_mps);
  double fastest_mps = 0;
  for (int i = 0; i < 1000; ++i) {
    const double moved = MinimumJerk((i + 1) / 1000.0) - MinimumJerk(i / 1000.0);
    fastest_mps = std::max(fastest_mps, moved * distance_m / (duration_s / 1000));
  }
  EXPECT_NEAR(fastest_mps, peak_mps, 1e-3);
}

}  // namespace
}  // namespace pickbed::tests
