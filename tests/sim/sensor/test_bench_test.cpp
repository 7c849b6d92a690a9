#include "sim/sensor/test_bench.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// For every shipped profile, measured noise agrees with the formulas.
TEST(SensorTestBench, MeasuredNoiseMatchesTheFormulas) {
  for (const std::string& name : SensorProfileNames()) {
    const SensorProfile p = LoadSensorProfile(name);
    const double distance_m = TrialDistance_m(p);
    EXPECT_GT(distance_m, p.min_range_m);
    EXPECT_LT(distance_m, p.max_range_m);
    for (const NoiseSample& s : NoiseByDistance(p)) {
      EXPECT_NEAR(s.lost_share, s.lost_formula_share, 0.02) << name << " at " << s.at << " m";
      // Quantization adds a twelfth of its squared step only if noise spreads the readings over
      // several steps.
      if (ReadingStep_m(p, s.at, 600) > 1.2 * s.axial_m) continue;
      EXPECT_NEAR(s.measured_m, s.formula_m, 0.12 * s.formula_m) << name << " at " << s.at << " m";
    }
    for (const NoiseSample& s : NoiseBySlant(p, distance_m)) {
      if (s.at > 1.3) continue;  // for steeper planes, depth changes over the measured columns
      EXPECT_NEAR(s.lost_share, s.lost_formula_share, 0.03) << name << " at " << s.at << " rad";
      EXPECT_NEAR(s.measured_m, s.formula_m, 0.15 * s.formula_m) << name << " at " << s.at;
    }
  }
}

TEST(SensorTestBench, SceneHasBoxBoardsAndColoredAreas) {
  const SensorScene scene = MakeSensorScene(2);
  EXPECT_FLOAT_EQ(scene.depth_m(0, 0), 2);
  EXPECT_FLOAT_EQ(scene.depth_m(90, 100), 1.6f);  // the box
  const auto [near, far] =
      std::minmax_element(scene.depth_m.pixels().begin(), scene.depth_m.pixels().end());
  EXPECT_GT(*near, 1.4f);
  EXPECT_EQ(*far, 2);
  int black = 0, white = 0;
  for (const Rgb8& c : scene.color.pixels()) {
    black += c.g < 10;
    white += c == Rgb8{255, 255, 255};
  }
  EXPECT_GT(black, 3000);
  EXPECT_GT(white, 3000);
  // Slants of the boards, from two neighboring points of each.
  for (const auto& [row, degrees] : {std::pair{52, 30.0}, {134, 50.0}, {215, 70.0}, {297, 80.0}}) {
    int x = scene.camera.width() - 1;
    while (scene.depth_m(x, row) == 2) --x;
    const auto point = [&](int column) {
      return BackProject(scene.camera, column, row, scene.depth_m(column, row));
    };
    const Eigen::Vector3d along = point(x) - point(x - 1);
    EXPECT_NEAR(std::atan(along.z() / along.x()) * 180 / std::numbers::pi, degrees, 0.5);
  }
}

}  // namespace
}  // namespace pickbed::tests
