#include "eval/draw/overlay.h"

#include <gtest/gtest.h>

#include "eval/draw/canvas.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

int CountPixels(const Image<Rgb8>& image, const Rgb8& not_this) {
  int count = 0;
  for (const Rgb8& pixel : image.pixels()) count += !(pixel == not_this);
  return count;
}

ObjectSet UnitCubes() {
  auto model = std::make_shared<ObjectModel>();
  model->mesh_O = BinMesh(Bin{{0.04, 0.04, 0.04}, 0.001, 0.5});
  return {model};
}

TEST(ColorizeDepth, HolesAreBlackAndNearDiffersFromFar) {
  Image<float> depth_m(4, 1, 0.f);
  depth_m(1, 0) = 0.5f;
  depth_m(2, 0) = 0.8f;
  depth_m(3, 0) = 1.0f;
  const Image<Rgb8> image = ColorizeDepth(depth_m);
  EXPECT_EQ(image(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_FALSE(image(1, 0) == image(3, 0));
  EXPECT_GT(image(1, 0).r, image(1, 0).b);  // near has a warm colour
}

TEST(ColorizeIds, NeighborsDifferInColourAndBackgroundIsBlack) {
  Image<uint16_t> ids(3, 1);
  ids(1, 0) = 1;
  ids(2, 0) = 2;
  const Image<Rgb8> image = ColorizeIds(ids);
  EXPECT_EQ(image(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_FALSE(image(1, 0) == image(2, 0));
}

TEST(DrawOverlay, PoseIsDrawnOnlyWhereItProjects) {
  const Camera camera{{200, 160, 300, 300, 99.5, 79.5}, Pose::Identity()};
  const RgbdFrame frame{camera.intrinsics, Image<Rgb8>(200, 160), Image<float>(200, 160)};
  const ObjectSet objects = UnitCubes();
  std::vector<PoseHypothesis> hypotheses(1);
  hypotheses[0].X_CO = Translation({0.05, 0, 0.5});
  const Image<Rgb8> image = DrawOverlay({frame, camera, objects, hypotheses});
  EXPECT_GT(CountPixels(image, Rgb8{}), 60);
  // The cube is 0.05 / 0.5 * 300 = 30 px right of the center and at most 0.04 m wide.
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 100; ++x) EXPECT_EQ(image(x, y), Rgb8{}) << x << " " << y;
  }
  const std::vector<PoseHypothesis> none;
  EXPECT_EQ(CountPixels(DrawOverlay({frame, camera, objects, none}), Rgb8{}), 0);
}

TEST(Canvas, TextStaysWithinItsWidth) {
  constexpr Rgb8 kPaper{250, 250, 250}, kInk{20, 20, 20};
  const std::string long_text = "a name that no tile of this width would hold";
  ASSERT_GT(TextWidth(long_text), 100);
  const auto written = [&](const std::string& text, int width_px) {
    Canvas canvas(400, 30, kPaper);
    canvas.TextWithin(width_px, text, 10, 20, kInk);
    return canvas.Take();
  };
  const Image<Rgb8> image = written(long_text, 100);
  EXPECT_GT(CountPixels(image, kPaper), 100);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 112; x < image.width(); ++x) ASSERT_EQ(image(x, y), kPaper) << x;
  }
  EXPECT_EQ(written("short", 100), written("short", 390));
}

TEST(ContactSheet, ContainsEveryTile) {
  const std::vector<Image<Rgb8>> tiles{Image<Rgb8>(20, 10, {255, 0, 0}),
                                       Image<Rgb8>(20, 10, {0, 255, 0}),
                                       Image<Rgb8>(20, 10, {0, 0, 255})};
  const Image<Rgb8> sheet = ContactSheet(tiles, {"a", "b", "c"}, 2);
  for (const Rgb8 color : {Rgb8{255, 0, 0}, Rgb8{0, 255, 0}, Rgb8{0, 0, 255}}) {
    EXPECT_EQ(std::count(sheet.pixels().begin(), sheet.pixels().end(), color), 200);
  }
}

}  // namespace
}  // namespace pickbed::tests
