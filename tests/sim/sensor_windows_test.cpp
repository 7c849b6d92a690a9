#include "sim/sensor_windows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

#include "scenes/random.h"
#include "sim/sensor_noise.h"

namespace pickbed {
namespace {

constexpr int kWidth = 320, kHeight = 240;

// Rows of the field that sets `along`, and of what decides over losses.
struct Fields {
  Image<float> along{kWidth, kHeight}, aside{kWidth, kHeight}, loss{kWidth, kHeight};
};

Fields DrawFields(uint64_t seed, double spacing_px) {
  // Keys next to each other give the same numbers, one place further on.
  const uint64_t key = Rng(seed).Next();
  CorrelatedNumbers correlated(key, kWidth, spacing_px);
  SensorNumbers numbers(kWidth);
  Fields fields;
  for (int y = 0; y < kHeight; ++y) {
    correlated.Fill(y, numbers);
    std::copy_n(numbers.along.data(), kWidth, fields.along.row(y));
    std::copy_n(numbers.aside.data(), kWidth, fields.aside.row(y));
    std::copy_n(numbers.loss.data(), kWidth, fields.loss.row(y));
  }
  return fields;
}

// Mean product of the values of two fields, the second one (dx, dy) further on.
double Product(const Image<float>& a, const Image<float>& b, int dx, int dy) {
  double sum = 0;
  for (int y = 0; y + dy < kHeight; ++y) {
    for (int x = 0; x + dx < kWidth; ++x) sum += static_cast<double>(a(x, y)) * b(x + dx, y + dy);
  }
  return sum / ((kWidth - dx) * (kHeight - dy));
}

TEST(SensorWindows, FieldsHaveUnitVarianceAndTheirCorrelation) {
  // Much alike at one pixel and 0 beyond two spacings; numbers that repeat or are not scaled fail
  // this.
  for (const double spacing_px : {2.5, 4.0, 6.6}) {
    double variance = 0, along_x = 0, along_y = 0, far = 0, apart = 0;
    constexpr int kFields = 8;
    for (int i = 0; i < kFields; ++i) {
      const Fields f = DrawFields(1000 + i, spacing_px);
      const int step = static_cast<int>(std::lround(2 * spacing_px));
      variance += Product(f.along, f.along, 0, 0) / kFields;
      along_x += Product(f.along, f.along, 1, 0) / kFields;
      along_y += Product(f.along, f.along, 0, 1) / kFields;
      far += Product(f.along, f.along, step + 1, 0) / kFields;
      apart += Product(f.along, f.aside, 0, 0) / kFields;
    }
    EXPECT_NEAR(variance, 1, 0.03) << spacing_px;
    EXPECT_NEAR(along_x, along_y, 0.03) << spacing_px;
    EXPECT_GT(along_x, spacing_px > 5 ? 0.9 : 0.7) << spacing_px;
    EXPECT_LT(along_x, 0.99) << spacing_px;
    EXPECT_NEAR(far, 0, 0.03) << spacing_px;
    EXPECT_NEAR(apart, 0, 0.03) << spacing_px;
  }
}

TEST(SensorWindows, FieldsAtOneSpacingAreAlikeAsTheirWeightsAre) {
  // The mean of w0 w1 / (w0^2 + w1^2) over the places between two knots, of w0 + w1 = 1.
  constexpr int kSpacing_px = 5, kFields = 16;
  double expected = 0, alike_x = 0, alike_y = 0;
  for (int i = 0; i < kSpacing_px; ++i) {
    const double w = static_cast<double>(i) / kSpacing_px;
    expected += w * (1 - w) / (w * w + (1 - w) * (1 - w)) / kSpacing_px;
  }
  for (int i = 0; i < kFields; ++i) {
    const Fields f = DrawFields(i, kSpacing_px);
    alike_x += Product(f.along, f.along, kSpacing_px, 0) / kFields;
    alike_y += Product(f.along, f.along, 0, kSpacing_px) / kFields;
  }
  EXPECT_NEAR(alike_x, expected, 0.015);  // 0.279
  EXPECT_NEAR(alike_y, expected, 0.015);
}

TEST(SensorWindows, LossesStayUniformAndComeInBlobs) {
  std::vector<int> deciles(10, 0);
  double both = 0, any = 0;
  for (int i = 0; i < 16; ++i) {
    const Fields f = DrawFields(77 + i, 5);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x + 1 < kWidth; ++x) {
        ASSERT_GE(f.loss(x, y), 0);
        ASSERT_LT(f.loss(x, y), 1);
        ++deciles[static_cast<int>(10 * f.loss(x, y))];
        any += f.loss(x, y) > 0.99f;
        both += f.loss(x, y) > 0.99f && f.loss(x + 1, y) > 0.99f;
      }
    }
  }
  const double all = 16.0 * (kWidth - 1) * kHeight;
  for (const int count : deciles) EXPECT_NEAR(count / all, 0.1, 0.01);
  EXPECT_NEAR(any / all, 0.01, 0.002);
  EXPECT_GT(both / any, 0.5);  // 0.01 for losses of their own
}

TEST(SensorWindows, RowsDoNotDependOnThoseAskedForBefore) {
  CorrelatedNumbers all(5, kWidth, 3.3), one(5, kWidth, 3.3);
  SensorNumbers of_all(kWidth), of_one(kWidth);
  for (int y = 0; y <= 57; ++y) all.Fill(y, of_all);
  one.Fill(57, of_one);
  EXPECT_EQ(of_all.along, of_one.along);
  EXPECT_EQ(of_all.loss, of_one.loss);
}

// Against the definition: the least over all edge pixels.
TEST(SensorWindows, EdgeDistancesAreThoseOfTheDefinition) {
  Rng rng(3);
  Image<float> depth(40, 30, 1.0f);
  for (int i = 0; i < 3; ++i) {
    depth(2 + rng.Index(36), 2 + rng.Index(26)) = 0.9f;  // an edge of it and its four neighbours
  }
  constexpr uint8_t kFarthest = 9;
  const Image<uint8_t> distances = EdgeDistances_px(depth, 0.05f, kFarthest);
  std::map<int, int> seen;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      int least = kFarthest;
      for (int v = 0; v < 30; ++v) {
        for (int u = 0; u < 40; ++u) {
          const auto differs = [&](int nu, int nv) {
            return depth.Contains(nu, nv) && std::abs(depth(nu, nv) - depth(u, v)) > 0.05f;
          };
          if (differs(u - 1, v) || differs(u + 1, v) || differs(u, v - 1) || differs(u, v + 1)) {
            least = std::min(least, std::max(std::abs(u - x), std::abs(v - y)));
          }
        }
      }
      ASSERT_EQ(distances(x, y), least) << x << " " << y;
      ++seen[least];
    }
  }
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[kFarthest], 0);
}

const CameraIntrinsics kCamera{kWidth, kHeight, 600, 600, 159.5, 119.5};

Image<float> Sensed(const Image<float>& depth_m, const SensorProfile& profile, uint64_t seed) {
  Rng rng(seed);
  return ApplySensorNoise({depth_m, kCamera, nullptr}, profile, rng);
}

// A board at `near_m` between columns 140 and 179 of a wall at `far_m`.
Image<float> Board(float near_m, float far_m) {
  Image<float> depth(kWidth, kHeight, far_m);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 140; x < 180; ++x) depth(x, y) = near_m;
  }
  return depth;
}

TEST(SensorWindows, LossesFallLinearlyWithTheDistanceToAnEdge) {
  SensorProfile of_these_pixels, of_coarser_pixels;
  of_these_pixels.edge_dropout = of_coarser_pixels.edge_dropout = 0.6;
  of_these_pixels.window_px = 8;
  of_coarser_pixels.window_px = 4, of_coarser_pixels.lateral_focal_px = kCamera.fx / 2;
  for (const SensorProfile& profile : {of_these_pixels, of_coarser_pixels}) {
    const Image<float> sensed = Sensed(Board(0.8f, 1.0f), profile, 4);
    for (int distance = 0; distance < 8; ++distance) {
      int lost = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (const int x : {139 - distance, 140 + distance, 179 - distance, 180 + distance}) {
          lost += sensed(x, y) == 0;
        }
      }
      const double share = std::max(0.0, 0.6 * (1 - distance / 4.0));
      EXPECT_NEAR(lost / (4.0 * kHeight), share, share > 0 ? 0.05 : 0) << distance;
    }
  }
}

// A surface without an edge loses nothing to windows, whatever their size.
TEST(SensorWindows, WindowsOfAnySizeLoseNothingWithoutAnEdge) {
  SensorProfile profile;
  profile.edge_dropout = 1, profile.window_px = 100, profile.lateral_focal_px = 50;
  EXPECT_EQ(WindowWidth_px(profile, kCamera.fx), 510);
  const Image<float> wall(kWidth, kHeight, 1.0f);
  EXPECT_TRUE(std::ranges::equal(Sensed(wall, profile, 2).pixels(), wall.pixels()));
}

TEST(SensorWindows, CorrelationLeavesSigmaAndSharesAsTheyAre) {
  SensorProfile profile;
  profile.axial_sigma_m = 0.002, profile.random_dropout = 0.05;
  profile.correlation_px = 2.5, profile.lateral_focal_px = kCamera.fx / 2;
  EXPECT_EQ(ErrorSpacing_px(profile, kCamera.fx), 5);
  EXPECT_EQ(ErrorSpacing_px(profile, kCamera.fx / 5), 0) << "of single pixels";
  const Image<float> wall(kWidth, kHeight, 1.0f);
  double sum2 = 0, neighbors = 0;
  int64_t read = 0, pairs = 0, lost = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const Image<float> sensed = Sensed(wall, profile, seed);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double error = (sensed(x, y) - 1) / 0.002;
        if (sensed(x, y) == 0) {
          ++lost;
          continue;
        }
        sum2 += error * error, ++read;
        if (x == 0 || sensed(x - 1, y) == 0) continue;
        neighbors += error * (sensed(x - 1, y) - 1) / 0.002, ++pairs;
      }
    }
  }
  EXPECT_NEAR(sum2 / static_cast<double>(read), 1, 0.03);
  EXPECT_GT(neighbors / static_cast<double>(pairs), 0.85);  // 0 without
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(lost + read), 0.05, 0.006);
}

// Without a projector as well; what a row shades does not reach the rows below.
TEST(SensorWindows, ShadowsOfTheSensorAloneStayInTheirRow) {
  SensorProfile profile;
  profile.sensor_x_m = 0.05;
  Image<float> depth = Board(0.8f, 1.0f);
  for (int y = kHeight / 2; y < kHeight; ++y) std::fill_n(depth.row(y), kWidth, 1.0f);
  const Image<float> sensed = Sensed(depth, profile, 1);
  const auto lost = [&](int y) { return std::count(sensed.row(y), sensed.row(y) + kWidth, 0.0f); };
  EXPECT_NEAR(lost(0), 0.05 * kCamera.fx * (1 / 0.8 - 1), 1);
  EXPECT_EQ(lost(kHeight / 2 - 1), lost(0));
  EXPECT_EQ(lost(kHeight / 2), 0);
  EXPECT_EQ(lost(kHeight - 1), 0);
}

// Seen from between the two, a board shades the wall on both sides, each by its own baseline.
TEST(SensorWindows, DepthLaidOverAnotherImageIsShadedOnBothSides) {
  SensorProfile profile;
  profile.baseline_m = 0.05, profile.sensor_x_m = -0.025;
  const Image<float> sensed = Sensed(Board(0.8f, 1.0f), profile, 1);
  int left = 0, right = 0;
  for (int x = 0; x < kWidth; ++x) {
    (x < 160 ? left : right) += sensed(x, 100) == 0;
    if (x >= 140 && x < 180) {
      EXPECT_EQ(sensed(x, 100), 0.8f);
    }
  }
  const double per_m = kCamera.fx * (1 / 0.8 - 1);
  EXPECT_NEAR(left, 0.05 * per_m, 1);
  EXPECT_NEAR(right, 0.025 * per_m, 1);
  // Depth itself is triangulated over all 75 mm.
  profile.disparity_step_px = 0.125;
  EXPECT_NEAR(TriangulationBaseline_m(profile), 0.075, 1e-12);
  EXPECT_NEAR(ReadingStep_m(profile, 2, 600), 4 * 0.125 / (600 * 0.075), 1e-9);
}

}  // namespace
}  // namespace pickbed
