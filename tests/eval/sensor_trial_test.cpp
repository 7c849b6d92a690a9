#include "eval/sensor_trial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "eval/report/draw_chart.h"

namespace pickbed {
namespace {

// What the sheet shows side by side agrees, for every profile that is shipped.
TEST(SensorTrial, MeasuredNoiseIsThatOfTheFormulas) {
  for (const std::string& name : SensorProfileNames()) {
    const SensorProfile p = LoadSensorProfile(name);
    const double distance_m = TrialDistance_m(p);
    EXPECT_GT(distance_m, p.min_range_m);
    EXPECT_LT(distance_m, p.max_range_m);
    for (const NoiseSample& s : NoiseByDistance(p)) {
      EXPECT_NEAR(s.lost_share, s.lost_formula_share, 0.02) << name << " at " << s.at << " m";
      // Steps add a twelfth of their square only where noise spreads readings over several.
      if (ReadingStep_m(p, s.at, 600) > 1.2 * s.axial_m) continue;
      EXPECT_NEAR(s.measured_m, s.formula_m, 0.12 * s.formula_m) << name << " at " << s.at << " m";
    }
    for (const NoiseSample& s : NoiseBySlant(p, distance_m)) {
      if (s.at > 1.3) continue;  // steeper, depth changes over the columns that are measured
      EXPECT_NEAR(s.lost_share, s.lost_formula_share, 0.03) << name << " at " << s.at << " rad";
      EXPECT_NEAR(s.measured_m, s.formula_m, 0.15 * s.formula_m) << name << " at " << s.at;
    }
  }
}

TEST(SensorTrial, TheSceneHasWhatItsCaptionSays) {
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
  // The boards' slants, from two neighbouring points of each.
  for (const auto& [row, degrees] : {std::pair{52, 30.0}, {134, 50.0}, {215, 70.0}, {297, 80.0}}) {
    int x = scene.camera.width - 1;
    while (scene.depth_m(x, row) == 2) --x;
    const auto point = [&](int column) {
      return BackProject(scene.camera, column, row, scene.depth_m(column, row));
    };
    const Eigen::Vector3d along = point(x) - point(x - 1);
    EXPECT_NEAR(std::atan(along.z() / along.x()) * 180 / std::numbers::pi, degrees, 0.5);
  }
}

TEST(DrawDepthError, TellsNearerFartherAndHoles) {
  const Image<float> ideal(4, 1, 1.0f);
  Image<float> seen = ideal;
  seen(1, 0) = 1.01f, seen(2, 0) = 0.995f, seen(3, 0) = 0;
  const Image<Rgb8> error = DrawDepthError(ideal, seen, 0.01);
  EXPECT_EQ(error(0, 0), (Rgb8{255, 255, 255}));
  EXPECT_GT(error(1, 0).r, error(1, 0).b + 250);
  EXPECT_EQ(error(2, 0).b, 255);
  EXPECT_NEAR(error(2, 0).r, 128, 2);
  EXPECT_EQ(error(3, 0), Rgb8{});
}

TEST(DrawChart, PutsAPointWhereItsValueIs) {
  const Rgb8 red{255, 0, 0};
  const auto height_of_dot = [&](double y) {
    const Chart chart{
        "x", "y", {{"", {{0, 0}, {1, 10}}, {0, 0, 255}}, {"", {{0.5, y}}, red, true}}};
    const Image<Rgb8> image = DrawChart(chart, 300, 200);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < 200; ++v) {
      for (int u = 0; u < 300; ++u) {
        if (image(u, v) == red) sum += v, ++count;
      }
    }
    return count > 0 ? sum / count : -1;
  };
  const double at_2 = height_of_dot(2), at_5 = height_of_dot(5), at_8 = height_of_dot(8);
  EXPECT_GT(at_8, 0);
  EXPECT_NEAR(at_2 - at_5, at_5 - at_8, 1.5);
  EXPECT_GT(at_2 - at_8, 60);
}

}  // namespace
}  // namespace pickbed
