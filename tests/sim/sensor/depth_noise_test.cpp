#include "sim/sensor/depth_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/error.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal_px = 340;

Image<float> Flat(double depth_m) {
  return Image<float>(kWidth, kHeight, static_cast<float>(depth_m));
}

Image<float> Sensed(const Image<float>& depth_m, const SensorProfile& profile, Rng& rng) {
  return ApplySensorNoise(
      {depth_m, CameraIntrinsics{kWidth, kHeight, kFocal_px, kFocal_px, 159.5, 119.5}}, profile,
      rng);
}

struct Statistics {
  double mean = 0, sigma = 0, holes = 0;  // holes as a fraction of all pixels
};

Statistics StatisticsOf(const Image<float>& depth_m) {
  double sum = 0, sum2 = 0;
  int count = 0;
  for (const float z : depth_m.pixels()) {
    if (z <= 0) continue;
    sum += z, sum2 += static_cast<double>(z) * z, ++count;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, sum2 / count - mean * mean)),
          1 - static_cast<double>(count) / static_cast<double>(depth_m.size())};
}

SensorProfile Only(void (*set)(SensorProfile&)) {
  SensorProfile profile;
  set(profile);
  return profile;
}

TEST(SensorNoise, IdealProfileChangesNothing) {
  Rng rng(1);
  const Image<float> depth = Flat(0.7);
  EXPECT_TRUE(ChangesNothing(SensorProfile()));
  EXPECT_EQ(Sensed(depth, SensorProfile(), rng), depth);
}

TEST(SensorNoise, AxialSigmaGrowsWithTheSquareOfDepth) {
  const SensorProfile profile = Only([](SensorProfile& p) { p.axial_sigma_m = 0.001; });
  for (const double z : {0.5, 1.0, 2.0}) {
    Rng rng(3);
    const Statistics s = StatisticsOf(Sensed(Flat(z), profile, rng));
    // Standard errors of 77 thousand samples: 0.4 % of sigma for the mean, 0.25 % for sigma.
    EXPECT_NEAR(s.mean, z, 0.015 * 0.001 * z * z + 1e-7);
    EXPECT_NEAR(s.sigma, 0.001 * z * z, 0.015 * 0.001 * z * z);
    EXPECT_EQ(s.holes, 0);
  }
}

TEST(SensorNoise, AxialNoiseIsGaussianAndUncorrelated) {
  const SensorProfile profile = Only([](SensorProfile& p) { p.axial_sigma_m = 0.001; });
  Rng rng(4);
  const Image<float> noisy = Sensed(Flat(1), profile, rng);
  int over_1 = 0, over_2 = 0, over_3 = 0;
  double neighbors = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double a = (noisy(x, y) - 1) / 0.001;
      over_1 += std::abs(a) > 1, over_2 += std::abs(a) > 2, over_3 += std::abs(a) > 3;
      if (x > 0) neighbors += a * (noisy(x - 1, y) - 1) / 0.001;
    }
  }
  const double n = kWidth * kHeight;
  EXPECT_NEAR(over_1 / n, 0.3173, 0.01);
  EXPECT_NEAR(over_2 / n, 0.0455, 0.004);
  EXPECT_NEAR(over_3 / n, 0.0027, 0.001);
  EXPECT_NEAR(neighbors / n, 0, 0.02);
}

TEST(SensorNoise, RandomDropoutHasItsProbability) {
  const SensorProfile profile = Only([](SensorProfile& p) { p.random_dropout = 0.02; });
  Rng rng(5);
  EXPECT_NEAR(StatisticsOf(Sensed(Flat(1), profile, rng)).holes, 0.02, 0.002);
}

TEST(SensorNoise, OnlyEdgePixelsAreLostToEdgeDropout) {
  const SensorProfile profile =
      Only([](SensorProfile& p) { p.edge_dropout = 0.45, p.edge_step_m = 0.012; });
  // Steps of 20 mm every 16 columns, and of 10 mm (no edge) every 16 rows.
  Image<float> depth(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      depth(x, y) =
          1 + 0.02f * static_cast<float>(x / 16 % 2) + 0.01f * static_cast<float>(y / 16 % 2);
    }
  }
  Rng rng(6);
  const Image<float> noisy = Sensed(depth, profile, rng);
  int edges = 0, lost_edges = 0, lost_elsewhere = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool edge = (x % 16 == 0 && x > 0) || (x % 16 == 15 && x < kWidth - 1);
      edges += edge;
      (edge ? lost_edges : lost_elsewhere) += noisy(x, y) == 0;
    }
  }
  EXPECT_EQ(edges, 38 * kHeight);
  EXPECT_NEAR(1.0 * lost_edges / edges, 0.45, 0.02);
  EXPECT_EQ(lost_elsewhere, 0);
}

// On a slope, jitter causes noise of slope times sigma and no bias.
TEST(SensorNoise, LateralJitterHasItsSigmaInPixels) {
  const SensorProfile for_these_pixels = Only([](SensorProfile& p) { p.lateral_sigma_px = 0.4; });
  const SensorProfile for_coarser_pixels =
      Only([](SensorProfile& p) { p.lateral_sigma_px = 0.2, p.lateral_focal_px = kFocal_px / 2; });
  constexpr float kSlope = 0.002f;  // m per px, only in x
  Image<float> depth(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) depth(x, y) = 0.5f + kSlope * static_cast<float>(x);
  }
  for (const SensorProfile& profile : {for_these_pixels, for_coarser_pixels}) {
    Rng rng(7);
    const Image<float> noisy = Sensed(depth, profile, rng);
    Image<float> jitter(kWidth - 8, kHeight);  // without the borders
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 4; x < kWidth - 4; ++x) {
        jitter(x - 4, y) = 10 + (noisy(x, y) - depth(x, y)) / kSlope;  // in px, positive
      }
    }
    const Statistics s = StatisticsOf(jitter);
    EXPECT_NEAR(s.mean, 10, 0.01);
    EXPECT_NEAR(s.sigma, 0.4, 0.008);
  }
}

TEST(SensorNoise, JitterCausesNoReadingsBetweenSurfaces) {
  const SensorProfile profile = Only([](SensorProfile& p) { p.lateral_sigma_px = 0.4; });
  Image<float> depth = Flat(1.0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) depth(x, y) = 0.5f;
  }
  Rng rng(8);
  int exchanged = 0;
  const Image<float> noisy = Sensed(depth, profile, rng);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_TRUE(noisy(x, y) == 0.5f || noisy(x, y) == 1.0f);
      exchanged += noisy(x, y) != depth(x, y);
    }
  }
  // P(jitter above half a pixel) = 10.6 % for the column on either side of the step.
  EXPECT_NEAR(exchanged / (2.0 * kHeight), 0.106, 0.05);
}

TEST(SensorNoise, ReadingsAreMultiplesOfTheStep) {
  const SensorProfile profile =
      Only([](SensorProfile& p) { p.quantization_m = 0.0005, p.axial_sigma_m = 0.001; });
  Rng rng(9);
  const Image<float> noisy = Sensed(Flat(0.8302), profile, rng);  // between two steps
  for (const float z : noisy.pixels()) {
    ASSERT_NEAR(z, 0.8302, 0.01);
    ASSERT_NEAR(z / 0.0005, std::round(z / 0.0005), 1e-3);
  }
}

TEST(SensorNoise, HolesStayHolesAndRangeIsLimited) {
  SensorProfile profile = LoadSensorProfile("structured_light");
  Image<float> depth = Flat(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; x += 3) depth(x, y) = 0;
    depth(1, y) = 0.2f, depth(2, y) = 5.0f;  // outside the range of 0.3 to 3 m
  }
  Rng rng(10);
  const Image<float> noisy = Sensed(depth, profile, rng);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_TRUE(noisy(x, y) == 0 || (noisy(x, y) >= 0.3f && noisy(x, y) <= 3.0f));
      ASSERT_TRUE(x % 3 != 0 || noisy(x, y) == 0);
    }
  }
}

TEST(SensorNoise, DependsOnlyOnTheStateOfTheRng) {
  const SensorProfile profile = LoadSensorProfile("structured_light");
  Rng a(11), b(11), c(12);
  const Image<float> first = Sensed(Flat(1), profile, a);
  EXPECT_EQ(first, Sensed(Flat(1), profile, b));
  EXPECT_NE(first, Sensed(Flat(1), profile, a));  // the state of the generator has changed
  EXPECT_NE(first, Sensed(Flat(1), profile, c));
}

TEST(SensorNoise, SeedZeroIsAValidSeed) {
  const SensorProfile profile = LoadSensorProfile("structured_light");
  Rng zero(0), zero_again(0), one(1);
  const Image<float> first = Sensed(Flat(1), profile, zero);
  EXPECT_EQ(first, Sensed(Flat(1), profile, zero_again));
  EXPECT_NE(first, Sensed(Flat(1), profile, one));
  // Standard error of 77 thousand samples: 0.00023.
  EXPECT_NEAR(StatisticsOf(first).holes, 0.004, 0.001);
}

TEST(SensorNoise, ImagesOfDifferentSizesAreRefused) {
  const CameraIntrinsics other{320, 200, 340, 340, 160, 100};
  const Image<float> depth = Flat(1);
  Rng rng(1);
  EXPECT_THROW(ApplySensorNoise({depth, other}, SensorProfile(), rng), InputError);
  const CameraIntrinsics same{kWidth, kHeight, 340, 340, 160, 100};
  const Image<Rgb8> color(4, 4), none;
  EXPECT_THROW(ApplySensorNoise({depth, same, &color}, SensorProfile(), rng), InputError);
  EXPECT_EQ(ApplySensorNoise({depth, same, &none}, SensorProfile(), rng), depth);
}

}  // namespace
}  // namespace pickbed::tests
