#include "eval/stats/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "scenes/base/random.h"
#include "tests/support/simulated_scenes.h"

namespace pickbed::tests {
namespace {

// Values from the closed form with z = 1.959964 (Newcombe 1998, table I, method 3).
TEST(WilsonInterval, EqualsPublishedCases) {
  const Interval a = WilsonInterval(81, 263);
  EXPECT_NEAR(a.low, 0.2553, 5e-5);
  EXPECT_NEAR(a.high, 0.3662, 5e-5);
  const Interval b = WilsonInterval(15, 148);
  EXPECT_NEAR(b.low, 0.0624, 5e-5);
  EXPECT_NEAR(b.high, 0.1605, 5e-5);
  const Interval c = WilsonInterval(0, 20);
  EXPECT_NEAR(c.low, 0, 1e-12);
  EXPECT_NEAR(c.high, 0.1611, 5e-5);
  const Interval d = WilsonInterval(1, 29);
  EXPECT_NEAR(d.low, 0.0061, 5e-5);
  EXPECT_NEAR(d.high, 0.1718, 5e-5);
}

TEST(WilsonInterval, NoAttemptsGiveTheWholeRange) {
  const Interval none = WilsonInterval(0, 0);
  EXPECT_EQ(none.low, 0);
  EXPECT_EQ(none.high, 1);
}

TEST(WilsonInterval, ExchangeOfSuccessAndFailureMirrorsIt) {
  for (int k = 0; k <= 12; ++k) {
    const Interval a = WilsonInterval(k, 12), b = WilsonInterval(12 - k, 12);
    EXPECT_NEAR(a.low, 1 - b.high, 1e-12);
    EXPECT_LE(a.low, k / 12.0 + 1e-12);
    EXPECT_GE(a.high, k / 12.0 - 1e-12);
  }
}

// Newcombe (1998) gives 0.2553 to 0.3662 for 81 of 263. One sample per scene is Wilson's case, and
// scenes without samples change nothing.
TEST(ClusterInterval, EqualsWilsonForOneSamplePerScene) {
  std::vector<Cluster> scenes(263, {0, 1});
  for (int i = 0; i < 81; ++i) scenes[3 * i].hits = 1;
  scenes.insert(scenes.begin() + 5, 7, {0, 0});
  const Interval interval = ClusterInterval(scenes);
  EXPECT_NEAR(interval.low, 0.2553, 5e-5);
  EXPECT_NEAR(interval.high, 0.3662, 5e-5);
}

// All samples of a scene agree, so the interval must be as wide as for one sample per scene.
TEST(ClusterInterval, SamplesOfOneSceneAreNotIndependent) {
  std::vector<Cluster> scenes;
  for (int i = 0; i < 40; ++i) scenes.push_back({i % 2 ? 25 : 0, 25});
  const Interval clustered = ClusterInterval(scenes);
  const Interval single = WilsonInterval(20, 40), many = WilsonInterval(500, 1000);
  EXPECT_NEAR(clustered.high - clustered.low, single.high - single.low, 0.02);
  EXPECT_GT(clustered.high - clustered.low, 3 * (many.high - many.low));
}

// The formula for scenes of equal size: the variance of the scene means, with n / (n - 1) for the
// jackknife, in Wilson's form with Student's t.
TEST(ClusterInterval, EqualsTheFormulaForScenesOfEqualSize) {
  std::vector<Cluster> scenes;
  const std::vector<int> hits{8, 6, 9, 7, 10, 5, 8, 9, 4, 7};
  double mean = 0, squares = 0;
  for (const int h : hits) {
    scenes.push_back({h, 10});
    mean += h / 100.0;
  }
  for (const int h : hits) squares += (h / 10.0 - mean) * (h / 10.0 - mean);
  const double variance = squares / 10 * (10.0 / 9) / 9;
  // The fourth moment leaves all nine degrees of freedom: 0.7 * 2 * (sum of squares)^2 / its
  // spread is 13.9. Student's t at 0.975 with 9 degrees is 2.262157.
  const double t = 2.262157, n = mean * (1 - mean) / variance;
  const Interval interval = ClusterInterval(scenes);
  const double center = (mean + t * t / (2 * n)) / (1 + t * t / n);
  const double half = t / (1 + t * t / n) * std::sqrt(mean * (1 - mean) / n + t * t / (4 * n * n));
  EXPECT_NEAR(interval.low, center - half, 1e-6);
  EXPECT_NEAR(interval.high, center + half, 1e-6);
}

// If all samples agree, the correlation within a scene cannot be estimated.
TEST(ClusterInterval, WidthIsNeverZero) {
  const std::vector<Cluster> all(20, {15, 15}), none(20, {0, 15}), half(20, {5, 10});
  EXPECT_EQ(ClusterInterval(all).high, 1);
  EXPECT_GT(ClusterInterval(all).low, WilsonInterval(20, 20).low);
  EXPECT_LT(ClusterInterval(all).low, WilsonInterval(300, 300).low);
  EXPECT_EQ(ClusterInterval(none).low, 0);
  EXPECT_NEAR(ClusterInterval(none).high, 1 - ClusterInterval(all).low, 1e-12);
  EXPECT_LT(ClusterInterval(half).low, 0.45);
  EXPECT_GT(ClusterInterval(half).high, 0.55);
}

// A run in which every pick succeeds must not look worse than the same run with one failure.
TEST(ClusterInterval, AllSuccessesAreNoWorseThanOneFailure) {
  for (const int bins : {5, 6, 8, 20, 40}) {
    for (const std::vector<int>& sizes :
         {std::vector{1}, std::vector{1, 2}, std::vector{8}, std::vector{3, 14, 15}}) {
      std::vector<Cluster> all;
      for (int i = 0; i < bins; ++i) {
        const int size = sizes[i % sizes.size()];
        all.push_back({size, size});
      }
      const Interval perfect = ClusterInterval(all);
      EXPECT_EQ(perfect.high, 1);
      for (size_t i = 0; i < sizes.size(); ++i) {
        std::vector<Cluster> one_failure = all;
        --one_failure[i].hits;
        const Interval worse = ClusterInterval(one_failure);
        EXPECT_GE(perfect.low, worse.low) << bins << " bins, failure in bin " << i;
        EXPECT_LE(perfect.high - perfect.low, worse.high - worse.low + 1e-12) << bins;
      }
    }
  }
}

TEST(ClusterInterval, TooFewBinsLeaveItUnknown) {
  std::vector<Cluster> bins(kMinBinsOfInterval - 1, {13, 14});
  bins.push_back({0, 0});
  EXPECT_FALSE(ClusterInterval(bins).is_known()) << "a bin without samples does not count";
  EXPECT_FALSE(PairedInterval(bins, bins).is_known());
  EXPECT_FALSE(ClusterInterval(std::vector<Cluster>(kMinBinsOfInterval - 1, {1, 1})).is_known());
  bins.back() = {14, 14};
  EXPECT_TRUE(ClusterInterval(bins).is_known());
  EXPECT_TRUE(PairedInterval(bins, bins).is_known());
}

// The rates of few bins at which the rule for kMinBinsOfInterval was chosen.
TEST(ClusterInterval, FewestBinsCoverTheTruth) {
  for (const double rate : {0.5, 0.9, 0.98}) {
    for (const double correlation : {0.0, 0.3}) {
      Rng rng(5);
      int covered = 0;
      constexpr int kOfFew = 4000;
      for (int experiment = 0; experiment < kOfFew; ++experiment) {
        const Interval interval = ClusterInterval(
            DrawScenes(kMinBinsOfInterval, rate, correlation, UniformSize(8, 14), rng));
        covered += interval.low <= rate && rate <= interval.high;
      }
      EXPECT_GE(covered, 0.94 * kOfFew) << rate << " " << correlation;
    }
  }
}

TEST(ClusterInterval, ExchangeOfHitsAndMissesMirrorsIt) {
  Rng rng(8);
  std::vector<Cluster> scenes = DrawScenes(12, 0.7, 0.3, UniformSize(1, 20), rng), exchanged;
  for (const Cluster& scene : scenes)
    exchanged.push_back({scene.samples - scene.hits, scene.samples});
  EXPECT_NEAR(ClusterInterval(scenes).low, 1 - ClusterInterval(exchanged).high, 1e-12);
  EXPECT_NEAR(ClusterInterval(scenes).high, 1 - ClusterInterval(exchanged).low, 1e-12);
}

TEST(ClusterInterval, NoSamplesLeaveItUnknown) {
  EXPECT_FALSE(ClusterInterval(std::vector<Cluster>(10, {0, 0})).is_known());
}

constexpr int kExperiments = 10000;

double CoverageOf(int scenes, double rate, double correlation, const SceneSize& size) {
  Rng rng(5);
  int covered = 0;
  for (int experiment = 0; experiment < kExperiments; ++experiment) {
    const Interval interval = ClusterInterval(DrawScenes(scenes, rate, correlation, size, rng));
    covered += interval.low <= rate && rate <= interval.high;
  }
  return covered / static_cast<double>(kExperiments);
}

// 95 % intervals cover the truth in 93 to 97 % of 10,000 experiments. The whole grid is measured by
// tests/figures/interval_figures.cpp.
TEST(ClusterInterval, CoversTheTruth) {
  for (const double rate : {0.1, 0.5, 0.9}) {
    for (const double correlation : {0.0, 0.1, 0.5}) {
      const double of_few = CoverageOf(40, rate, correlation, UniformSize(1, 20));
      EXPECT_GE(of_few, 0.93) << rate << " " << correlation;
      EXPECT_LE(of_few, 0.97) << rate << " " << correlation;
    }
  }
  const double of_unequal = CoverageOf(100, 0.8, 0.2, GeometricSize(0.15, 40));
  EXPECT_GE(of_unequal, 0.93);
  EXPECT_LE(of_unequal, 0.97);
}

// Rates differ much between scenes, but by the same amount in each pair. Pairing removes the spread
// between scenes from the interval.
TEST(PairedInterval, PairingRemovesTheSpreadBetweenScenes) {
  std::vector<Cluster> before, after;
  for (int i = 0; i < 40; ++i) {
    before.push_back({i % 2 ? 50 : 10, 100});
    after.push_back({before.back().hits + 20, 100});
  }
  const Interval rise = PairedInterval(before, after);
  EXPECT_NEAR(rise.low, 0.2, 5e-3);
  EXPECT_NEAR(rise.high, 0.2, 5e-3);
  EXPECT_LT(rise.low, rise.high);
  std::vector<Cluster> shuffled(after);
  std::rotate(shuffled.begin(), shuffled.begin() + 1, shuffled.end());
  const Interval unpaired = PairedInterval(before, shuffled);
  EXPECT_GT(unpaired.high - unpaired.low, 0.1);
}

// One outcome per scene gives the adjusted interval of Bonett and Price, ((c + 1) - (b + 1)) / (n +
// 2). Its Wald variance is multiplied twice by (n + 2) / (n + 1) of the jackknife. b = 6, c = 14, n
// = 60.
TEST(PairedInterval, EqualsBonettPriceForOneOutcomePerScene) {
  std::vector<Cluster> before(60, {1, 1}), after(60, {1, 1});
  for (int i = 0; i < 6; ++i) after[i].hits = 0;
  for (int i = 6; i < 20; ++i) before[i].hits = 0;
  const double p12 = 7 / 62.0, p21 = 15 / 62.0, d = p21 - p12;
  const double half = 1.959964 * std::sqrt((p12 + p21 - d * d) / 62) * 62 / 61;
  const Interval rise = PairedInterval(before, after);
  EXPECT_NEAR(rise.low, d - half, 1e-6);
  EXPECT_NEAR(rise.high, d + half, 1e-6);
}

TEST(PairedInterval, CoversTheTruth) {
  for (const double correlation : {0.1, 0.5}) {
    Rng rng(6);
    int covered = 0;
    for (int experiment = 0; experiment < kExperiments; ++experiment) {
      const ScenePairs pairs = DrawPairs(40, 0.6, correlation, 0.1, 0.5, UniformSize(1, 20), rng);
      const Interval rise = PairedInterval(pairs.before, pairs.after);
      covered += rise.low <= 0.1 && 0.1 <= rise.high;
    }
    EXPECT_GE(covered, 0.93 * kExperiments) << correlation;
    EXPECT_LE(covered, 0.97 * kExperiments) << correlation;
  }
}

TEST(PairedInterval, NoSamplesLeaveItUnknownAndPairsAreRequired) {
  const std::vector<Cluster> nothing(10, {0, 0}), some(10, {1, 2}), one{{1, 2}};
  EXPECT_FALSE(PairedInterval(nothing, some).is_known());
  EXPECT_FALSE(PairedInterval(some, nothing).is_known());
  EXPECT_THROW(PairedInterval(one, std::vector<Cluster>{{1, 2}, {1, 2}}), std::logic_error);
}

// Equal runs differ by zero, but the interval has the width of no discordance among as many scenes.
TEST(PairedInterval, EqualRunsKeepAPositiveWidth) {
  const std::vector<Cluster> scenes(40, {9, 10});
  const Interval rise = PairedInterval(scenes, scenes);
  EXPECT_NEAR(rise.low, -rise.high, 1e-12);
  EXPECT_GT(rise.high, 0.04);
  EXPECT_LT(rise.high, 0.1);
}

// Errors that are correlated within a scene: exp(scene + noise), with median 1.
ValueClusters DrawErrors(int scenes, Rng& rng) {
  ValueClusters errors(scenes);
  for (auto& scene : errors) {
    const double common = 0.7 * rng.Normal();
    scene.resize(1 + rng.Index(12));
    for (double& error : scene) error = std::exp(common + 0.5 * rng.Normal());
  }
  return errors;
}

TEST(MedianInterval, CoversTheTruth) {
  Rng rng(9);
  int covered = 0;
  for (int experiment = 0; experiment < kExperiments; ++experiment) {
    const Interval interval = MedianInterval(DrawErrors(40, rng));
    covered += interval.low <= 1 && 1 <= interval.high;
  }
  EXPECT_GE(covered, 0.93 * kExperiments);
  EXPECT_LE(covered, 0.97 * kExperiments);
}

TEST(MedianInterval, EndsAreValuesAndInfiniteOnesAreAllowed) {
  const double infinity = std::numeric_limits<double>::infinity();
  ValueClusters scenes;
  for (int i = 0; i < 20; ++i) scenes.push_back({1.0 * i, i < 4 ? infinity : 0.5 + i});
  EXPECT_EQ(MedianOf({{3, 1}, {2, 4}}), 2);
  const Interval interval = MedianInterval(scenes);
  EXPECT_LT(interval.low, MedianOf(scenes));
  EXPECT_GT(interval.high, MedianOf(scenes));
  EXPECT_LT(interval.high, infinity);
  EXPECT_TRUE(std::isnan(MedianOf({{}, {}})));
  EXPECT_FALSE(MedianInterval({{}, {}}).is_known());
  EXPECT_FALSE(MedianInterval({{1, 2}, {3, 4}, {5, 6}, {7, 8}}).is_known()) << "four bins";
}

TEST(RateText, HasPercentWithOneDecimalAndItsInterval) {
  EXPECT_EQ(PercentText(0.125), "12.5 %");
  EXPECT_EQ(PercentNumber(1), "100.0");
  EXPECT_EQ(IntervalText({0.081, 0.1836}), "[8.1, 18.4]");
  EXPECT_EQ(RateText({1, 8, {0.081, 0.1836}}), "12.5 % [8.1, 18.4]");
  EXPECT_EQ(RateText({}), "-");
}

TEST(RateText, TooFewBinsHaveNoBrackets) {
  EXPECT_EQ(IntervalText(Interval::Unknown()), "too few bins");
  EXPECT_EQ(RateText({1, 8, Interval::Unknown()}), "12.5 % (too few bins)");
  EXPECT_EQ(RateText(0.125, Interval::Unknown()), "12.5 % (too few bins)");
  EXPECT_EQ(IntervalCells(Interval::Unknown()), ",");
  EXPECT_EQ(IntervalCells({0.25, 0.5}), "0.25,0.5");
}

TEST(FewBinsText, SaysWhetherThereIsAnIntervalAtAll) {
  EXPECT_EQ(FewBinsText(4), "4 bins are too few for an interval, which needs 5; use 20 or more.");
  EXPECT_EQ(FewBinsText(5),
            "5 bins are few: the intervals are wide and approximate; use 20 or more.");
  EXPECT_EQ(FewBinsText(20), "");
}

TEST(PercentText, CountsAreExactAndNoCountIsADash) {
  EXPECT_EQ(PercentText(1, 8), "12.5 %");
  EXPECT_EQ(PercentText(23, 80), "28.8 %") << "28.75 rounds to even, 100 * 0.2875 is below it";
  EXPECT_EQ(PercentText(0, 0), "-");
}

TEST(PointsText, SignIsShownAndAnUnknownIntervalIsNamed) {
  EXPECT_EQ(PointsText(0.0125), "+1.2");
  EXPECT_EQ(PointsText(-0.5, {-1, 0.25}), "-50.0 [-100.0, +25.0]");
  EXPECT_EQ(PointsText(0.1, {-kInfinity, kInfinity}), "+10.0 (too few bins)");
}

TEST(ClusterRate, EqualsTheSumsAndIntervalOfTheClusters) {
  const std::vector<Cluster> clusters{{1, 4}, {3, 4}, {2, 3}, {4, 4}, {3, 4}};
  const ReportRate rate = ClusterRate(clusters);
  EXPECT_EQ(rate.hits, 13);
  EXPECT_EQ(rate.samples, 19);
  EXPECT_EQ(rate.ci95.low, ClusterInterval(clusters).low);
  EXPECT_EQ(rate.ci95.high, ClusterInterval(clusters).high);
}

}  // namespace
}  // namespace pickbed::tests
