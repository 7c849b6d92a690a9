#include "eval/stats/median_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// 40 scenes with `errors_per_scene` equal errors each: 1, 2, ... 40.
ValueClusters EqualWithinScenes(int errors_per_scene) {
  ValueClusters scenes;
  for (int scene = 1; scene <= 40; ++scene) scenes.emplace_back(errors_per_scene, scene);
  return scenes;
}

// Ten equal errors of one scene count as one.
TEST(ErrorMedian, UnitsOfTheIntervalAreScenes) {
  const ErrorMedian once = MedianWithin(EqualWithinScenes(1)),
                    often = MedianWithin(EqualWithinScenes(10));
  EXPECT_EQ(once.value, 20);
  EXPECT_EQ(often.value, 20);
  EXPECT_NEAR(often.ci95.low, once.ci95.low, 1);
  EXPECT_NEAR(often.ci95.high, once.ci95.high, 1);
}

// Values 1 .. n, one per scene.
ErrorMedian MedianOfSingles(int n) {
  ValueClusters scenes;
  for (int i = 1; i <= n; ++i) scenes.push_back({static_cast<double>(i)});
  return MedianWithin(scenes);
}

// The l-th of n values is above the median with a probability of at most 2.5 %, from sums of
// binomial coefficients over 2^n.
TEST(ErrorMedian, OneValuePerSceneGivesRanksOfTheSignTest) {
  const std::map<int, std::pair<double, double>> ranks{{6, {1, 6}},    {8, {1, 8}},   {9, {2, 8}},
                                                       {10, {2, 9}},   {15, {4, 12}}, {20, {6, 15}},
                                                       {30, {10, 21}}, {40, {14, 27}}};
  for (const auto& [n, ends] : ranks) {
    EXPECT_EQ(MedianOfSingles(n).ci95.low, ends.first) << n;
    EXPECT_EQ(MedianOfSingles(n).ci95.high, ends.second) << n;
  }
}

TEST(ErrorMedian, OneValuePerSceneCoversTheTruthIn95Percent) {
  constexpr int kExperiments = 10000;
  for (const int scenes : {6, 13, 40}) {
    Rng rng(scenes);
    int covered = 0;
    for (int experiment = 0; experiment < kExperiments; ++experiment) {
      ValueClusters errors;
      for (int i = 0; i < scenes; ++i) errors.push_back({std::exp(rng.Normal())});
      const Interval interval = MedianWithin(errors).ci95;
      covered += interval.low <= 1 && 1 <= interval.high;
    }
    EXPECT_GE(covered, 0.945 * kExperiments) << scenes;
    EXPECT_LE(covered, 0.985 * kExperiments) << scenes;
  }
}

TEST(ErrorMedian, FewValuesLeaveTheIntervalUnknown) {
  const ErrorMedian five = MedianWithin({{1}, {2}, {3}, {}, {4}, {5}});
  EXPECT_EQ(five.value, 3);
  EXPECT_TRUE(std::isinf(five.ci95.low));
  EXPECT_TRUE(std::isinf(five.ci95.high));
  EXPECT_TRUE(std::isfinite(MedianWithin({{1, 2}, {3}, {4, 5}, {6}, {7}}).ci95.high));
  EXPECT_EQ(MedianText(five, 1), "3.0 (too few bins)");
  EXPECT_EQ(MedianCells(five), "3,,");
}

TEST(ErrorMedian, FewScenesLeaveTheIntervalUnknown) {
  const std::vector<double> many(40, 1.0);
  EXPECT_FALSE(MedianWithin({{}, many, many, many, many, {}}).ci95.is_known());
  EXPECT_TRUE(MedianWithin({many, many, many, many, many}).ci95.is_known());
}

TEST(ErrorMedian, NoValuesGiveEmptyText) {
  const ErrorMedian none = MedianWithin({{}, {}});
  EXPECT_EQ(MedianText(none, 1), "-");
  EXPECT_EQ(MedianCells(none), ",,");
}

TEST(ErrorMedian, UnitChangeAppliesToBothEnds) {
  const ErrorMedian m = ErrorMedian{0.0125, {0.01, 0.02}}.Times(1e3);
  EXPECT_EQ(MedianText(m, 1), "12.5 [10.0, 20.0]");
  EXPECT_EQ(MedianCells(m), "12.5,10,20");
}

}  // namespace
}  // namespace pickbed::tests
