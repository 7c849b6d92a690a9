#include "sim/appearance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/check.h"

namespace pickbed {
namespace {

TEST(Appearance, DrawsFillTheirRangesAndStayInside) {
  const AppearanceRanges ranges = WideAppearance();
  Rng rng(1);
  double tint_least = 1, tint_most = 0, lamp_least = 9, lamp_most = -9;
  int shadows = 0;
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    const Light light = RandomLight(ranges, rng);
    const Material material = RandomMaterial(ranges, rng);
    EXPECT_DOUBLE_EQ(light.ambient + light.diffuse, 1);
    shadows += light.shadow;
    lamp_least = std::min(lamp_least, light.position_W.z());
    lamp_most = std::max(lamp_most, light.position_W.z());
    tint_least = std::min(tint_least, material.tint.minCoeff());
    tint_most = std::max(tint_most, material.tint.maxCoeff());
    EXPECT_GE(material.grain, ranges.grain.min);
    EXPECT_LE(material.grain, ranges.grain.max);
  }
  EXPECT_GE(tint_least, ranges.tint.min);
  EXPECT_LT(tint_least, ranges.tint.min + 0.01);
  EXPECT_LE(tint_most, ranges.tint.max);
  EXPECT_GT(tint_most, ranges.tint.max - 0.01);
  EXPECT_GE(lamp_least, ranges.lamp_z_m.min);
  EXPECT_LE(lamp_most, ranges.lamp_z_m.max);
  EXPECT_GT(lamp_most - lamp_least, 0.95);
  EXPECT_NEAR(shadows, ranges.shadow_share * kDraws, 100);  // 5 standard deviations
}

TEST(Appearance, DefaultsArePlain) {
  Rng rng(1);
  const AppearanceRanges ranges;
  EXPECT_EQ(RandomMaterial(ranges, rng), Material());
  EXPECT_FALSE(RandomLight(ranges, rng).shadow);
}

TEST(Appearance, BackgroundIsPaintedWhereNothingIsSeen) {
  RenderedImage image;
  image.color = Image<Rgb8>(40, 30, Rgb8{1, 2, 3});
  image.depth_m = Image<float>(40, 30);
  for (int x = 10; x < 20; ++x) image.depth_m(x, 7) = 1;
  AppearanceRanges ranges;
  ranges.background = {0.5, 1};
  ranges.background_cell_px = {8, 8};
  Rng rng(2);
  PaintBackground(ranges, rng, image);
  for (int x = 0; x < 40; ++x) {
    if (x >= 10 && x < 20) {
      EXPECT_EQ(image.color(x, 7), (Rgb8{1, 2, 3}));
    } else {
      EXPECT_GE(image.color(x, 7).r, 127);
    }
  }
  EXPECT_EQ(image.color(0, 0), image.color(7, 7));  // one cell
  EXPECT_NE(image.color(0, 0), image.color(8, 0));
}

TEST(Appearance, RangesOutsideTheirLimitsAreNamed) {
  AppearanceRanges ranges;
  ranges.shadow_share = 1.5;
  EXPECT_THROW(ranges.Validate(), InputError);
  ranges = {};
  ranges.gloss = {0.5, 0.2};
  EXPECT_THROW(ranges.Validate(), InputError);
}

}  // namespace
}  // namespace pickbed
