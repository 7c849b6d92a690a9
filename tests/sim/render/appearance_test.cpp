#include "sim/render/appearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "scenes/bin/bin.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

ObjectSet TwoBoxes() {
  ObjectSet boxes;
  for (const double side_m : {0.05, 0.08}) {
    auto box = std::make_shared<ObjectModel>();
    box->mesh_O = BoxMesh({side_m, side_m, 0.04});
    boxes.push_back(box);
  }
  return boxes;
}

Scene BoxesInBin() {
  return {Bin{},
          {{InstanceId{0}, ObjectId{0}, Translation({-0.08, 0, 0.02})},
           {InstanceId{1}, ObjectId{1}, Translation({0.08, 0.02, 0.02})}}};
}

// Far enough to see the surroundings of the bin.
Camera FromAbove() {
  return {{160, 120, 120, 120, 79.5, 59.5},
          LookAt({0, 0, 1.0}, {0, 0, 0}, Eigen::Vector3d::UnitY())};
}

TEST(Appearance, SamplesCoverTheirRangesAndStayInside) {
  const AppearanceRanges ranges = WideAppearance();
  Rng rng(1);
  double tint_min = 1, tint_max = 0, lamp_min = 9, lamp_max = -9;
  int shadows = 0;
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    const Light light = RandomLight(ranges, rng);
    const Material material = RandomMaterial(ranges, rng);
    EXPECT_DOUBLE_EQ(light.ambient + light.diffuse, 1);
    shadows += light.shadow;
    lamp_min = std::min(lamp_min, light.position_W.z());
    lamp_max = std::max(lamp_max, light.position_W.z());
    tint_min = std::min(tint_min, material.tint.minCoeff());
    tint_max = std::max(tint_max, material.tint.maxCoeff());
    EXPECT_GE(material.grain, ranges.grain.min);
    EXPECT_LE(material.grain, ranges.grain.max);
  }
  EXPECT_GE(tint_min, ranges.tint.min);
  EXPECT_LT(tint_min, ranges.tint.min + 0.01);
  EXPECT_LE(tint_max, ranges.tint.max);
  EXPECT_GT(tint_max, ranges.tint.max - 0.01);
  EXPECT_GE(lamp_min, ranges.lamp_z_m.min);
  EXPECT_LE(lamp_max, ranges.lamp_z_m.max);
  EXPECT_GT(lamp_max - lamp_min, 0.95);
  EXPECT_NEAR(shadows, ranges.shadow_share * kDraws, 100);  // 5 standard deviations
}

TEST(Appearance, DefaultRangesGiveThePlainMaterial) {
  Rng rng(1);
  const AppearanceRanges ranges;
  EXPECT_EQ(RandomMaterial(ranges, rng), Material());
  EXPECT_FALSE(RandomLight(ranges, rng).shadow);
}

TEST(Appearance, BackgroundIsPaintedWhereDepthIsMissing) {
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

// A fixed appearance gives the same image as plain rendering, byte for byte.
TEST(Appearance, FixedAppearanceEqualsThePlainImage) {
  const AppearanceRanges fixed = FixedAppearance();
  for (const BinIndex trial : {BinIndex(0), BinIndex(7)}) {
    const Light light = LampOf(fixed, 3, trial), plain;
    EXPECT_EQ(light.position_W, plain.position_W);
    EXPECT_EQ(light.ambient, plain.ambient);
    EXPECT_EQ(light.diffuse, plain.diffuse);
    EXPECT_EQ(light.shadow, plain.shadow);
    EXPECT_EQ(light.shadow_softness_m, plain.shadow_softness_m);
    EXPECT_EQ(MaterialOf(fixed, 3, trial, InstanceId{2}), Material());
  }
  SceneRenderer renderer(TwoBoxes(), Bin{});
  const RenderedImage plain = renderer.Render(BoxesInBin(), FromAbove());
  const RenderedImage fixed_image =
      RenderWithAppearance(renderer, BoxesInBin(), FromAbove(), fixed, 3, BinIndex(0), 0);
  EXPECT_EQ(fixed_image.color, plain.color);
  EXPECT_EQ(fixed_image.depth_m, plain.depth_m);
  EXPECT_EQ(fixed_image.ids, plain.ids);
}

TEST(Appearance, RangeOfOneValueGivesThatValue) {
  AppearanceRanges ranges = FixedAppearance();
  ranges.lamp_x_m = {0.1, 0.1};
  ranges.ambient = {0.25, 0.25};
  ranges.shadow_share = 1;
  ranges.tint = {0.5, 0.5};
  ranges.gloss = {0.75, 0.75};
  ranges.grain = {0.5, 0.5};
  ranges.grain_cells_pm = {250, 250};
  for (int i = 0; i < 20; ++i) {
    const Light light = LampOf(ranges, 1, BinIndex(i));
    EXPECT_EQ(light.position_W.x(), 0.1);
    EXPECT_EQ(light.ambient, 0.25);
    EXPECT_EQ(light.diffuse, 0.75);
    EXPECT_TRUE(light.shadow);
    const Material material = MaterialOf(ranges, 1, BinIndex(0), InstanceId(i));
    EXPECT_EQ(material.tint, Eigen::Vector3d::Constant(0.5));
    EXPECT_EQ(material.gloss, 0.75);
    EXPECT_EQ(material.grain, 0.5);
    EXPECT_EQ(material.grain_cells_pm, 250);
  }
}

TEST(Appearance, InstancesKeepTheirMaterialWhileTheBackgroundChanges) {
  AppearanceRanges ranges = FixedAppearance();
  ranges.tint = {0.3, 1};
  ranges.background = {0.1, 1};
  SceneRenderer renderer(TwoBoxes(), Bin{});
  const Scene both = BoxesInBin();
  const auto render = [&](const Scene& scene, int trial, int number) {
    return RenderWithAppearance(renderer, scene, FromAbove(), ranges, 5, BinIndex(trial), number);
  };
  const RenderedImage first = render(both, 0, 0), again = render(both, 0, 0);
  const RenderedImage second = render(both, 0, 1), other = render(both, 1, 0);
  EXPECT_EQ(first.color, again.color);
  EXPECT_EQ(first.depth_m, other.depth_m);
  // After the other instance is picked, the remaining instance looks the same.
  Scene one = both;
  one.objects.erase(one.objects.begin());
  const RenderedImage left = render(one, 0, 0);
  int seen = 0, changed = 0, behind = 0, redrawn = 0;
  for (size_t i = 0; i < first.ids.size(); ++i) {
    if (first.depth_m.data()[i] == 0) {
      ++behind;
      redrawn += !(first.color.data()[i] == second.color.data()[i]);
      continue;
    }
    EXPECT_EQ(first.color.data()[i], second.color.data()[i]);
    if (first.ids.data()[i] != both.objects[1].instance + 1) continue;
    ++seen;
    EXPECT_EQ(first.color.data()[i], left.color.data()[i]);
    changed += !(first.color.data()[i] == other.color.data()[i]);
  }
  EXPECT_GT(seen, 50);
  EXPECT_GT(changed, seen / 2) << "another trial gives the instance another tint";
  EXPECT_GT(behind, 100);
  EXPECT_GT(redrawn, behind / 2);
}

}  // namespace
}  // namespace pickbed::tests
