// Tests each sensor effect separately, against its formula.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sim/sensor/depth_noise.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr double kPi = std::numbers::pi;
const CameraIntrinsics kCamera{320, 240, 600, 600, 159.5, 119.5};

// Returns a plane at `z_m` on the optical axis, rotated about the camera's y axis (or x axis) by
// the angle. The angle is also its slant in the image center.
Image<float> Plane(double z_m, double angle_rad, bool about_x = false) {
  Image<float> depth(kCamera.width(), kCamera.height());
  for (int y = 0; y < kCamera.height(); ++y) {
    for (int x = 0; x < kCamera.width(); ++x) {
      const double along =
          about_x ? (y - kCamera.cy()) / kCamera.fy() : (x - kCamera.cx()) / kCamera.fx();
      const double closeness = 1 - along * std::tan(angle_rad);
      if (closeness > 0.05) depth(x, y) = static_cast<float>(z_m / closeness);
    }
  }
  return depth;
}

// Returns a step: `near_m` from column `step_x` on, `far_m` to the left of it.
Image<float> StepEdge(double near_m, double far_m, int step_x) {
  Image<float> depth(kCamera.width(), kCamera.height(), static_cast<float>(far_m));
  for (int y = 0; y < kCamera.height(); ++y) {
    for (int x = step_x; x < kCamera.width(); ++x) depth(x, y) = static_cast<float>(near_m);
  }
  return depth;
}

Image<float> Sensed(const Image<float>& depth_m, const SensorProfile& profile,
                    const Image<Rgb8>* color = nullptr) {
  Rng rng(5);
  return ApplySensorNoise({depth_m, kCamera, color}, profile, rng);
}

double HoleFraction(const Image<float>& depth_m, int x_begin, int x_end) {
  int holes = 0;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = x_begin; x < x_end; ++x) holes += depth_m(x, y) == 0;
  }
  return static_cast<double>(holes) / ((x_end - x_begin) * depth_m.height());
}

// Returns the sigma of the difference to the ideal depth, in metres. It uses the four center
// columns (or rows), where the slant equals the slant of the plane. The standard error of a sigma
// of 4 x 240 samples is 2.3 %.
double SigmaInTheCenter_m(const Image<float>& ideal, const Image<float>& sensed, bool rows) {
  double sum2 = 0;
  int count = 0;
  for (int y = rows ? 118 : 0; y < (rows ? 122 : 240); ++y) {
    for (int x = rows ? 0 : 158; x < (rows ? 320 : 162); ++x) {
      const double error = sensed(x, y) - ideal(x, y);
      sum2 += error * error, ++count;
    }
  }
  return std::sqrt(sum2 / count);
}

TEST(SensorEffects, AxialSigmaIsAPolynomialOfDepth) {
  SensorProfile p;
  p.axial_floor_m = 0.0015, p.axial_linear_m = -0.0005, p.axial_sigma_m = 0.0003;
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const Image<float> ideal = Plane(z, 0);
    const double expected = 1e-3 * (1.5 - 0.5 * z + 0.3 * z * z);
    EXPECT_NEAR(SigmaInTheCenter_m(ideal, Sensed(ideal, p), false), expected, 0.08 * expected);
  }
}

// The error of each pixel divided by the sigma for its depth and slant has unit variance. The slant
// is measured to the pixel's ray: for the plane n.X = z0 with n = (-tan, 0, 1), cos = n.r / (|n|
// |r|).
TEST(SensorEffects, AxialSigmaGrowsWithSlantToTheRay) {
  for (const double power : {-0.5, 0.0, 1.5, 2.0}) {
    SensorProfile p;
    p.axial_slant_m = 0.0005, p.axial_slant_power = power;
    for (const bool about_x : {false, true}) {
      for (const double degrees : {0.0, 20.0, 45.0, 60.0, 70.0}) {
        const double tangent = std::tan(degrees * kPi / 180);
        const Image<float> ideal = Plane(1.3, degrees * kPi / 180, about_x);
        const Image<float> sensed = Sensed(ideal, p);
        double sum2 = 0;
        int count = 0;
        for (int y = 0; y < kCamera.height(); ++y) {
          for (int x = 0; x < kCamera.width(); ++x) {
            const double u = (x - kCamera.cx()) / kCamera.fx(),
                         v = (y - kCamera.cy()) / kCamera.fy();
            const double cosine = (1 - (about_x ? v : u) * tangent) /
                                  std::sqrt((1 + tangent * tangent) * (1 + u * u + v * v));
            const double a = std::acos(cosine), ratio = a / (kPi / 2 - a), z = ideal(x, y);
            const double sigma = 0.0005 * std::pow(z, power) * ratio * ratio;
            if (sigma < 1e-5 || a > 1.45) continue;  // below the resolution of float; clamped
            sum2 += std::pow((sensed(x, y) - z) / sigma, 2), ++count;
          }
        }
        ASSERT_GT(count, 20000);
        EXPECT_NEAR(std::sqrt(sum2 / count), 1, 0.02) << power << " " << degrees << " " << about_x;
      }
    }
  }
}

TEST(SensorEffects, LateralJitterGrowsWithSlant) {
  SensorProfile p;
  p.lateral_sigma_px = 0.3, p.lateral_slant_px = 0.2, p.edge_step_m = 10;
  const double a = 1.0, z = 1;
  const Image<float> ideal = Plane(z, a);
  const double metres_per_px = z * std::tan(a) / kCamera.fx();  // on the plane, in the image center
  const double sigma_px = SigmaInTheCenter_m(ideal, Sensed(ideal, p), false) / metres_per_px;
  // On a plane, interpolation between pixels does not change the sigma of the jitter.
  EXPECT_NEAR(sigma_px, 0.3 + 0.2 * a / (kPi / 2 - a), 0.05);
}

TEST(SensorEffects, DisparityIsQuantized) {
  SensorProfile p;
  p.baseline_m = 0.05, p.disparity_step_px = 0.125, p.disparity_focal_px = 424;
  p.axial_sigma_m = 0.01;  // so that many steps occur
  const double fb = 424 * 0.05;
  int between = 0;
  for (const double z : {0.4, 1.0, 3.0}) {
    double largest_error = 0;
    const Image<float> wall = Sensed(Plane(z, 0), p);
    for (const float reading : wall.pixels()) {
      const double steps = fb / reading / 0.125;
      between += std::abs(steps - std::round(steps)) > 1e-3;
    }
    SensorProfile noiseless = p;
    noiseless.axial_sigma_m = 0;
    const Image<float> ramp = Plane(z, 0.7);
    const Image<float> read = Sensed(ramp, noiseless);
    for (size_t i = 0; i < ramp.size(); ++i) {
      if (read.data()[i] == 0) continue;
      largest_error = std::max(largest_error, std::abs(fb / ramp.data()[i] - fb / read.data()[i]));
    }
    EXPECT_LT(largest_error, 0.125 / 2 + 1e-3) << z;  // rounded to the nearest step, not down
    EXPECT_GT(largest_error, 0.125 / 2 - 5e-3) << z;
  }
  EXPECT_EQ(between, 0);
}

TEST(SensorEffects, ShadowOfAStepHasTheWidthGivenByTheBaseline) {
  for (const double baseline : {0.02, 0.05, 0.075, 0.15, -0.05}) {
    SensorProfile p;
    p.baseline_m = baseline;
    for (const double near_m : {0.5, 0.6, 0.7}) {
      const Image<float> ideal = StepEdge(near_m, 0.8, 200);
      const Image<float> sensed = Sensed(ideal, p);
      // The near side is on the right. A projector on the right sees less of the far side; a
      // projector on the left sees all of it.
      const double width_px = baseline > 0 ? baseline * kCamera.fx() * (1 / near_m - 1 / 0.8) : 0;
      for (const int y : {0, 100, 239}) {
        int lost = 0;
        for (int x = 0; x < 320; ++x) {
          lost += sensed(x, y) == 0;
          if (sensed(x, y) == 0) {
            EXPECT_TRUE(x < 200 && x >= 200 - width_px - 1) << x;
          } else {
            EXPECT_EQ(sensed(x, y), ideal(x, y));
          }
        }
        EXPECT_NEAR(lost, width_px, 1) << baseline << " " << near_m;
      }
    }
  }
}

TEST(SensorEffects, ShadowOfAReflectedSceneIsReflected) {
  SensorProfile right, left;
  right.baseline_m = 0.06, left.baseline_m = -0.06;
  const Image<float> scene = StepEdge(0.5, 0.9, 210);
  Image<float> reflected(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) reflected(x, y) = scene(319 - x, y);
  }
  const Image<float> a = Sensed(scene, right), b = Sensed(reflected, left);
  EXPECT_NEAR(HoleFraction(a, 0, 320), HoleFraction(b, 0, 320), 1.0 / 320);
  EXPECT_GT(HoleFraction(a, 0, 320), 0.05);
  EXPECT_EQ(HoleFraction(b, 320 - 210, 320 - 140), HoleFraction(b, 0, 320) * 320 / 70);
}

// The projector sees past a thin post on both sides. The shadow has the width of the post, and its
// distance from the post is the shadow width of a wide object.
TEST(SensorEffects, ShadowOfAThinPostHasItsWidth) {
  SensorProfile p;
  p.baseline_m = 0.1;
  Image<float> ideal = Plane(1.0, 0);
  for (int y = 0; y < 240; ++y) {
    for (int x = 200; x < 208; ++x) ideal(x, y) = 0.5f;
  }
  const Image<float> sensed = Sensed(ideal, p);  // disparities 120 and 60 px
  std::vector<int> lost;
  for (int x = 0; x < 320; ++x) {
    if (sensed(x, 50) == 0) lost.push_back(x);
  }
  ASSERT_NEAR(lost.size(), 8, 1);
  EXPECT_NEAR(lost.front(), 140, 1);
  EXPECT_NEAR(lost.back(), 147, 1);
}

// The board is so steep that neighboring pixels form edges. Its shadow still has no gaps.
TEST(SensorEffects, ShadowOfASteepBoardHasNoGaps) {
  SensorProfile p;
  p.baseline_m = 0.075;
  Image<float> ideal = Plane(1.0, 0);
  for (int y = 0; y < 240; ++y) {
    for (int x = 200; x < 216; ++x) ideal(x, y) = 0.6f + 0.02f * static_cast<float>(x - 200);
  }
  const Image<float> sensed = Sensed(ideal, p);
  const double width_px = 0.075 * kCamera.fx() * (1 / 0.6 - 1);
  int lost = 0;
  for (int x = 0; x < 200; ++x) lost += sensed(x, 9) == 0;
  EXPECT_NEAR(lost, width_px, 1);
  for (int x = 199; x > 200 - width_px + 1; --x) EXPECT_EQ(sensed(x, 9), 0) << x;
}

TEST(SensorEffects, PlanesSeenByTheProjectorCastNoShadow) {
  SensorProfile p;
  p.baseline_m = 0.075;
  for (const double degrees : {-70.0, -30.0, 0.0, 30.0, 70.0}) {
    EXPECT_EQ(HoleFraction(Sensed(Plane(0.8, degrees * kPi / 180), p), 0, 320), 0) << degrees;
  }
}

TEST(SensorEffects, GrazingDropoutMatchesItsFormula) {
  SensorProfile p;
  p.grazing_dropout = 0.8, p.grazing_start_rad = 1.0;
  for (const double a : {0.5, 0.98, 1.1, 1.3, 1.45}) {
    const double expected = std::max(0.0, 0.8 * (a - 1.0) / (kPi / 2 - 1.0));
    // Eight center columns; 1920 pixels, standard error at most 1.1 %.
    EXPECT_NEAR(HoleFraction(Sensed(Plane(0.3, a), p), 156, 164), expected,
                expected > 0 ? 0.035 : 0)
        << a;
  }
}

TEST(SensorEffects, DarkAndShinyDropoutMatchTheirFormula) {
  SensorProfile p;
  p.dark_dropout = 0.6, p.dark_luma = 0.2, p.shiny_dropout = 0.5, p.shiny_luma = 0.8;
  const Image<float> ideal = Plane(1, 0);
  const auto holes = [&](Rgb8 color) {
    const Image<Rgb8> image(kCamera.width(), kCamera.height(), color);
    return HoleFraction(Sensed(ideal, p, &image), 0, 320);
  };
  // 77 thousand pixels: standard error 0.18 %. The error of a luma is at most an eighth of a byte.
  EXPECT_NEAR(holes({0, 0, 0}), 0.6, 0.008);
  EXPECT_NEAR(holes({26, 26, 26}), 0.6 * (1 - 26 / 51.0), 0.008);
  EXPECT_EQ(holes({51, 51, 51}), 0);
  EXPECT_EQ(holes({128, 128, 128}), 0);
  EXPECT_EQ(holes({204, 204, 204}), 0);
  EXPECT_NEAR(holes({230, 230, 230}), 0.5 * 26 / 51.0, 0.008);
  EXPECT_NEAR(holes({255, 255, 255}), 0.5, 0.008);
  // Rec. 601: pure blue has luma 0.114, pure green 0.587.
  EXPECT_NEAR(holes({0, 0, 255}), 0.6 * (1 - 0.114 / 0.2), 0.012);
  EXPECT_EQ(holes({0, 255, 0}), 0);
  EXPECT_EQ(HoleFraction(Sensed(ideal, p), 0, 320), 0)
      << "no dark or shiny dropout without a color image";
}

TEST(SensorEffects, SurvivalProbabilitiesMultiply) {
  SensorProfile p;
  p.random_dropout = 0.3, p.dark_dropout = 0.5;
  const Image<Rgb8> black(kCamera.width(), kCamera.height());
  EXPECT_NEAR(HoleFraction(Sensed(Plane(1, 0), p, &black), 0, 320), 1 - 0.7 * 0.5, 0.008);
}

TEST(SensorEffects, FlyingPixelsAreUniformBetweenTheSurfaces) {
  SensorProfile p;
  p.flying_share = 0.4;
  const Image<float> ideal = StepEdge(0.5, 1.0, 160);
  const Image<float> sensed = Sensed(ideal, p);
  int flying = 0;
  double sum = 0, sum2 = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const float z = sensed(x, y);
      ASSERT_TRUE(z >= 0.5f && z <= 1.0f);
      if (x != 159 && x != 160) {
        ASSERT_EQ(z, ideal(x, y));
      } else if (z != ideal(x, y)) {
        ++flying, sum += z, sum2 += z * z;
      }
    }
  }
  EXPECT_NEAR(flying / 480.0, 0.4, 0.07);  // 3 standard errors of 480 pixels
  const double mean = sum / flying;
  EXPECT_NEAR(mean, 0.75, 0.04);
  EXPECT_NEAR(std::sqrt(sum2 / flying - mean * mean), 0.5 / std::sqrt(12.0), 0.02);
}

// Matching windows see edges from a distance, but only pixels at an edge are mixed.
TEST(SensorEffects, WindowsCauseNoMoreFlyingPixels) {
  SensorProfile p;
  p.flying_share = 1, p.edge_dropout = 1e-9, p.window_px = 8;
  const Image<float> ideal = StepEdge(0.5, 1.0, 160);
  const Image<float> sensed = Sensed(ideal, p);
  int flying = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (x == 159 || x == 160) {
        flying += sensed(x, y) != ideal(x, y);
      } else {
        ASSERT_EQ(sensed(x, y), ideal(x, y)) << x;
      }
    }
  }
  EXPECT_GT(flying, 475);  // of 480
}

TEST(SensorEffects, PixelNextToAHoleDoesNotFly) {
  SensorProfile p;
  p.flying_share = 1;
  const Image<float> ideal = StepEdge(0.5, 0, 160);
  EXPECT_EQ(Sensed(ideal, p), ideal);
}

TEST(SensorEffects, ReadingsAreWithinRange) {
  SensorProfile p;
  p.min_range_m = 0.5, p.max_range_m = 2, p.axial_sigma_m = 0.02;
  int lost = 0;
  const Image<float> sensed = Sensed(Plane(2, 0), p);
  for (const float z : sensed.pixels()) {
    ASSERT_TRUE(z == 0 || z <= 2);
    lost += z == 0;
  }
  // Half of the noise is above the limit.
  EXPECT_NEAR(lost / static_cast<double>(sensed.size()), 0.5, 0.01);
  EXPECT_EQ(HoleFraction(Sensed(Plane(0.4, 0), p), 0, 320), 1);
}

TEST(SensorEffects, UnusualImageSizesGiveFiniteReadings) {
  for (const std::string& name : SensorProfileNames()) {
    const SensorProfile p = LoadSensorProfile(name);
    for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {9, 1}, {2, 2}, {3, 5}}) {
      const CameraIntrinsics camera{width, height, 600, 600, 1, 1};
      for (const float z : {0.0f, 1e-4f, 0.8f, 90.0f}) {
        const Image<float> ideal(width, height, z);
        const Image<Rgb8> color(width, height, {90, 90, 90});
        Rng rng(1);
        const Image<float> sensed = ApplySensorNoise({ideal, camera, &color}, p, rng);
        for (const float reading : sensed.pixels()) {
          EXPECT_TRUE(std::isfinite(reading) && reading >= 0) << name;
          EXPECT_TRUE(z > 0 || reading == 0) << name;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
