#include "eval/error_median.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pickbed {
namespace {

// 40 scenes with these many errors each: 1, 2, ... 40, the same within a scene.
ValueClusters Alike(int errors_a_scene) {
  ValueClusters scenes;
  for (int scene = 1; scene <= 40; ++scene) scenes.emplace_back(errors_a_scene, scene);
  return scenes;
}

// What a scene says ten times it says once.
TEST(ErrorMedian, ScenesAreTheUnitsOfItsInterval) {
  const ErrorMedian once = MedianWithin(Alike(1)), often = MedianWithin(Alike(10));
  EXPECT_EQ(once.value, 20);
  EXPECT_EQ(often.value, 20);
  EXPECT_NEAR(often.ci95.low, once.ci95.low, 1);
  EXPECT_NEAR(often.ci95.high, once.ci95.high, 1);
  // Of 40 independent values the 14th and the 27th hold the median in 95 %.
  EXPECT_NEAR(once.ci95.low, 14, 1);
  EXPECT_NEAR(once.ci95.high, 27, 1);
}

TEST(ErrorMedian, OfFewValuesTheEndsAreUnknown) {
  const ErrorMedian five = MedianWithin({{1, 2}, {3}, {}, {4, 5}});
  EXPECT_EQ(five.value, 3);
  EXPECT_TRUE(std::isinf(five.ci95.low));
  EXPECT_TRUE(std::isinf(five.ci95.high));
  EXPECT_TRUE(std::isfinite(MedianWithin({{1, 2}, {3}, {4, 5}, {6}}).ci95.high));
  EXPECT_EQ(MedianText(five, 1), "3.0 [-, -]");
  EXPECT_EQ(MedianCells(five), "3,,");
}

TEST(ErrorMedian, OfOneSceneTheEndsAreUnknown) {
  EXPECT_TRUE(std::isinf(MedianWithin({{}, std::vector<double>(40, 1.0), {}}).ci95.high));
}

TEST(ErrorMedian, OfNothingIsTold) {
  const ErrorMedian none = MedianWithin({{}, {}});
  EXPECT_EQ(MedianText(none, 1), "-");
  EXPECT_EQ(MedianCells(none), ",,");
}

TEST(ErrorMedian, ChangesItsUnitWithBothEnds) {
  const ErrorMedian m = ErrorMedian{0.0125, {0.01, 0.02}}.Times(1e3);
  EXPECT_EQ(MedianText(m, 1), "12.5 [10.0, 20.0]");
  EXPECT_EQ(MedianCells(m), "12.5,10,20");
}

}  // namespace
}  // namespace pickbed
