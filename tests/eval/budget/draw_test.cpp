#include "eval/budget/draw.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Number of pixels of a color in each row.
std::map<int, int> RowsOf(const Image<Rgb8>& image, Rgb8 color) {
  std::map<int, int> rows;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const Rgb8& p = image(x, y);
      if (p.r == color.r && p.g == color.g && p.b == color.b) ++rows[y];
    }
  }
  return rows;
}

int Widest(const Image<Rgb8>& image, Rgb8 color) {
  int widest = 0;
  for (const auto& [y, width] : RowsOf(image, color)) widest = std::max(widest, width);
  return widest;
}

TEST(DrawWaterfall, BarWidthIsTheShareAndColorIsTheStage) {
  const Rgb8 all{150, 158, 168}, left{0, 138, 100}, grasp{126, 62, 152}, pose{204, 121, 167};
  const Image<Rgb8> image = DrawWaterfall({"t",
                                           "all",
                                           "all",
                                           {"picked", "", 26, {}},
                                           40,
                                           {{"a", "pose", 4, {}}, {"b", "grasp", 10, {}}}});
  const double whole = Widest(image, all);
  EXPECT_GT(whole, 500);
  EXPECT_NEAR(Widest(image, pose) / whole, 0.10, 0.005);
  EXPECT_NEAR(Widest(image, grasp) / whole, 0.25, 0.005);
  EXPECT_NEAR(Widest(image, left) / whole, 0.65, 0.005);
}

TEST(DrawWaterfall, EmptyWaterfallIsDrawn) {
  EXPECT_GT(DrawWaterfall({"t", "all", "all", {"picked", "", 0, {}}, 0, {}}).width(), 0);
}

TEST(DrawGains, IntervalWidthFollowsTheAxis) {
  const Rgb8 first{0, 114, 178};
  const Image<Rgb8> image = DrawGains(
      {"t",
       "x",
       "y",
       {{"none", {0, 0, {0, 0}}, {0, 0, {0, 0}}}, {"a", {0, 0.1, {0.05, 0.2}}, {0, 0, {0, 0}}}}});
  // The first color draws a dot without an interval, and an interval of 15 points as the widest
  // row.
  EXPECT_GT(Widest(image, first), 200);
}

}  // namespace
}  // namespace pickbed::tests
