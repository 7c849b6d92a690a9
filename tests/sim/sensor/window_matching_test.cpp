#include "sim/sensor/window_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

#include "scenes/base/random.h"
#include "sim/sensor/depth_noise.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kWindowWidth = 320, kWindowHeight = 240;

// Images of the numbers that set the error `along` and `aside`, and of the number that decides on
// dropout.
struct Fields {
  Image<float> along{kWindowWidth, kWindowHeight}, aside{kWindowWidth, kWindowHeight},
      dropout{kWindowWidth, kWindowHeight};
};

Fields DrawFields(uint64_t seed, double spacing_px) {
  // Successive keys give the same numbers, shifted by one position.
  const uint64_t key = Rng(seed).Next();
  CorrelatedNumbers correlated(key, kWindowWidth, spacing_px);
  SensorNumbers numbers(kWindowWidth);
  Fields fields;
  for (int y = 0; y < kWindowHeight; ++y) {
    correlated.Fill(y, numbers);
    std::copy_n(numbers.along.data(), kWindowWidth, fields.along.row(y));
    std::copy_n(numbers.aside.data(), kWindowWidth, fields.aside.row(y));
    std::copy_n(numbers.dropout.data(), kWindowWidth, fields.dropout.row(y));
  }
  return fields;
}

// Returns the mean product of two fields, the second shifted by (dx, dy).
double Product(const Image<float>& a, const Image<float>& b, int dx, int dy) {
  double sum = 0;
  for (int y = 0; y + dy < kWindowHeight; ++y) {
    for (int x = 0; x + dx < kWindowWidth; ++x)
      sum += static_cast<double>(a(x, y)) * b(x + dx, y + dy);
  }
  return sum / ((kWindowWidth - dx) * (kWindowHeight - dy));
}

TEST(SensorWindows, FieldsHaveUnitVarianceAndLimitedCorrelation) {
  // The correlation is high at one pixel and 0 beyond two spacings. Repeated or unscaled numbers
  // fail this test.
  for (const double spacing_px : {2.5, 4.0, 6.6}) {
    double variance = 0, along_x = 0, along_y = 0, far = 0, cross = 0;
    constexpr int kFields = 8;
    for (int i = 0; i < kFields; ++i) {
      const Fields f = DrawFields(1000 + i, spacing_px);
      const int step = static_cast<int>(std::lround(2 * spacing_px));
      variance += Product(f.along, f.along, 0, 0) / kFields;
      along_x += Product(f.along, f.along, 1, 0) / kFields;
      along_y += Product(f.along, f.along, 0, 1) / kFields;
      far += Product(f.along, f.along, step + 1, 0) / kFields;
      cross += Product(f.along, f.aside, 0, 0) / kFields;
    }
    EXPECT_NEAR(variance, 1, 0.03) << spacing_px;
    EXPECT_NEAR(along_x, along_y, 0.03) << spacing_px;
    EXPECT_GT(along_x, spacing_px > 5 ? 0.9 : 0.7) << spacing_px;
    EXPECT_LT(along_x, 0.99) << spacing_px;
    EXPECT_NEAR(far, 0, 0.03) << spacing_px;
    EXPECT_NEAR(cross, 0, 0.03) << spacing_px;
  }
}

TEST(SensorWindows, CorrelationAtOneSpacingMatchesTheWeights) {
  // The mean of w0 w1 / (w0^2 + w1^2) over the positions between two knots, with w0 + w1 = 1.
  constexpr int kSpacing_px = 5, kFields = 16;
  double expected = 0, correlation_x = 0, correlation_y = 0;
  for (int i = 0; i < kSpacing_px; ++i) {
    const double w = static_cast<double>(i) / kSpacing_px;
    expected += w * (1 - w) / (w * w + (1 - w) * (1 - w)) / kSpacing_px;
  }
  for (int i = 0; i < kFields; ++i) {
    const Fields f = DrawFields(i, kSpacing_px);
    correlation_x += Product(f.along, f.along, kSpacing_px, 0) / kFields;
    correlation_y += Product(f.along, f.along, 0, kSpacing_px) / kFields;
  }
  EXPECT_NEAR(correlation_x, expected, 0.015);  // 0.279
  EXPECT_NEAR(correlation_y, expected, 0.015);
}

TEST(SensorWindows, DropoutNumbersAreUniformAndClustered) {
  std::vector<int> deciles(10, 0);
  double both = 0, any = 0;
  for (int i = 0; i < 16; ++i) {
    const Fields f = DrawFields(77 + i, 5);
    for (int y = 0; y < kWindowHeight; ++y) {
      for (int x = 0; x + 1 < kWindowWidth; ++x) {
        ASSERT_GE(f.dropout(x, y), 0);
        ASSERT_LT(f.dropout(x, y), 1);
        ++deciles[static_cast<int>(10 * f.dropout(x, y))];
        any += f.dropout(x, y) > 0.99f;
        both += f.dropout(x, y) > 0.99f && f.dropout(x + 1, y) > 0.99f;
      }
    }
  }
  const double all = 16.0 * (kWindowWidth - 1) * kWindowHeight;
  for (const int count : deciles) EXPECT_NEAR(count / all, 0.1, 0.01);
  EXPECT_NEAR(any / all, 0.01, 0.002);
  EXPECT_GT(both / any, 0.5);  // 0.01 for independent numbers
}

TEST(SensorWindows, RowsDoNotDependOnEarlierRows) {
  CorrelatedNumbers all(5, kWindowWidth, 3.3), one(5, kWindowWidth, 3.3);
  SensorNumbers of_all(kWindowWidth), of_one(kWindowWidth);
  for (int y = 0; y <= 57; ++y) all.Fill(y, of_all);
  one.Fill(57, of_one);
  EXPECT_EQ(of_all.along, of_one.along);
  EXPECT_EQ(of_all.dropout, of_one.dropout);
}

// Compares with the definition: the minimum over all edge pixels.
TEST(SensorWindows, EdgeDistancesMatchTheDefinition) {
  Rng rng(3);
  Image<float> depth(40, 30, 1.0f);
  for (int i = 0; i < 3; ++i) {
    // The pixel and its four neighbors are edge pixels.
    depth(2 + rng.Index(36), 2 + rng.Index(26)) = 0.9f;
  }
  constexpr uint8_t kFarthest = 9;
  const Image<uint8_t> distances = EdgeDistances_px(depth, 0.05f, kFarthest);
  std::map<int, int> seen;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      int nearest = kFarthest;
      for (int v = 0; v < 30; ++v) {
        for (int u = 0; u < 40; ++u) {
          const auto differs = [&](int nu, int nv) {
            return depth.Contains(nu, nv) && std::abs(depth(nu, nv) - depth(u, v)) > 0.05f;
          };
          if (differs(u - 1, v) || differs(u + 1, v) || differs(u, v - 1) || differs(u, v + 1)) {
            nearest = std::min(nearest, std::max(std::abs(u - x), std::abs(v - y)));
          }
        }
      }
      ASSERT_EQ(distances(x, y), nearest) << x << " " << y;
      ++seen[nearest];
    }
  }
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[kFarthest], 0);
}

const CameraIntrinsics kWindowCamera{kWindowWidth, kWindowHeight, 600, 600, 159.5, 119.5};

Image<float> Sensed(const Image<float>& depth_m, const SensorProfile& profile, uint64_t seed) {
  Rng rng(seed);
  return ApplySensorNoise({depth_m, kWindowCamera, nullptr}, profile, rng);
}

// Returns a board at `near_m` in columns 140 to 179, in front of a wall at `far_m`.
Image<float> Board(float near_m, float far_m) {
  Image<float> depth(kWindowWidth, kWindowHeight, far_m);
  for (int y = 0; y < kWindowHeight; ++y) {
    for (int x = 140; x < 180; ++x) depth(x, y) = near_m;
  }
  return depth;
}

TEST(SensorWindows, DropoutFallsLinearlyWithTheDistanceToAnEdge) {
  SensorProfile for_these_pixels, for_coarser_pixels;
  for_these_pixels.edge_dropout = for_coarser_pixels.edge_dropout = 0.6;
  for_these_pixels.window_px = 8;
  for_coarser_pixels.window_px = 4, for_coarser_pixels.lateral_focal_px = kWindowCamera.fx() / 2;
  for (const SensorProfile& profile : {for_these_pixels, for_coarser_pixels}) {
    const Image<float> sensed = Sensed(Board(0.8f, 1.0f), profile, 4);
    for (int distance = 0; distance < 8; ++distance) {
      int lost = 0;
      for (int y = 0; y < kWindowHeight; ++y) {
        for (const int x : {139 - distance, 140 + distance, 179 - distance, 180 + distance}) {
          lost += sensed(x, y) == 0;
        }
      }
      const double share = std::max(0.0, 0.6 * (1 - distance / 4.0));
      EXPECT_NEAR(lost / (4.0 * kWindowHeight), share, share > 0 ? 0.05 : 0) << distance;
    }
  }
}

// A surface without an edge has no window dropout, for any window size.
TEST(SensorWindows, WindowsCauseNoDropoutWithoutAnEdge) {
  SensorProfile profile;
  profile.edge_dropout = 1, profile.window_px = 100, profile.lateral_focal_px = 50;
  EXPECT_EQ(WindowWidth_px(profile, kWindowCamera.fx()), 510);
  const Image<float> wall(kWindowWidth, kWindowHeight, 1.0f);
  EXPECT_TRUE(std::ranges::equal(Sensed(wall, profile, 2).pixels(), wall.pixels()));
}

TEST(SensorWindows, CorrelationDoesNotChangeSigmaAndDropout) {
  SensorProfile profile;
  profile.axial_sigma_m = 0.002, profile.random_dropout = 0.05;
  profile.correlation_px = 2.5, profile.lateral_focal_px = kWindowCamera.fx() / 2;
  EXPECT_EQ(ErrorSpacing_px(profile, kWindowCamera.fx()), 5);
  EXPECT_EQ(ErrorSpacing_px(profile, kWindowCamera.fx() / 5), 0)
      << "errors of single pixels are independent";
  const Image<float> wall(kWindowWidth, kWindowHeight, 1.0f);
  double sum2 = 0, neighbors = 0;
  int64_t read = 0, pairs = 0, lost = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const Image<float> sensed = Sensed(wall, profile, seed);
    for (int y = 0; y < kWindowHeight; ++y) {
      for (int x = 0; x < kWindowWidth; ++x) {
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
  EXPECT_GT(neighbors / static_cast<double>(pairs), 0.85);  // 0 without correlation
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(lost + read), 0.05, 0.006);
}

// This also holds without a projector. The shadow of one row does not reach the rows below.
TEST(SensorWindows, SensorOffsetShadowsStayInTheirRow) {
  SensorProfile profile;
  profile.sensor_x_m = 0.05;
  Image<float> depth = Board(0.8f, 1.0f);
  for (int y = kWindowHeight / 2; y < kWindowHeight; ++y)
    std::fill_n(depth.row(y), kWindowWidth, 1.0f);
  const Image<float> sensed = Sensed(depth, profile, 1);
  const auto lost = [&](int y) {
    return std::count(sensed.row(y), sensed.row(y) + kWindowWidth, 0.0f);
  };
  EXPECT_NEAR(lost(0), 0.05 * kWindowCamera.fx() * (1 / 0.8 - 1), 1);
  EXPECT_EQ(lost(kWindowHeight / 2 - 1), lost(0));
  EXPECT_EQ(lost(kWindowHeight / 2), 0);
  EXPECT_EQ(lost(kWindowHeight - 1), 0);
}

// Seen from between projector and sensor, a board shades the wall on both sides, each with its own
// baseline.
TEST(SensorWindows, DepthAlignedToAnotherImageHasShadowsOnBothSides) {
  SensorProfile profile;
  profile.baseline_m = 0.05, profile.sensor_x_m = -0.025;
  const Image<float> sensed = Sensed(Board(0.8f, 1.0f), profile, 1);
  int left = 0, right = 0;
  for (int x = 0; x < kWindowWidth; ++x) {
    (x < 160 ? left : right) += sensed(x, 100) == 0;
    if (x >= 140 && x < 180) {
      EXPECT_EQ(sensed(x, 100), 0.8f);
    }
  }
  const double per_m = kWindowCamera.fx() * (1 / 0.8 - 1);
  EXPECT_NEAR(left, 0.05 * per_m, 1);
  EXPECT_NEAR(right, 0.025 * per_m, 1);
  // Depth is triangulated over the full 75 mm.
  profile.disparity_step_px = 0.125;
  EXPECT_NEAR(TriangulationBaseline_m(profile), 0.075, 1e-12);
  EXPECT_NEAR(ReadingStep_m(profile, 2, 600), 4 * 0.125 / (600 * 0.075), 1e-9);
}

}  // namespace
}  // namespace pickbed::tests
