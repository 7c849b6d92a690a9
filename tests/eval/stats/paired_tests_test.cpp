#include "eval/stats/paired_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/support/simulated_scenes.h"

namespace pickbed::tests {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sums of Pascal's triangle: 2 (1 + 10 + 45) / 1024 for 2 of 10; 2 (1 + 8) / 256 for 1 of 8.
TEST(McNemarExact, EqualsHandComputedBinomial) {
  EXPECT_NEAR(McNemarExact({2, 8}), 112 / 1024.0, 1e-12);
  EXPECT_NEAR(McNemarExact({8, 2}), 112 / 1024.0, 1e-12);
  EXPECT_NEAR(McNemarExact({1, 7}), 18 / 256.0, 1e-12);
  EXPECT_NEAR(McNemarExact({0, 6}), 2 / 64.0, 1e-12);
  EXPECT_EQ(McNemarExact({5, 5}), 1);
  EXPECT_EQ(McNemarExact({0, 0}), 1);
}

// Agresti, Categorical Data Analysis, sec. 10.1: approval of the prime minister, with 150 and 86
// discordant pairs. The matched odds ratio is 86 / 150 = 0.57; the square root of chi-square is
// 4.17.
TEST(McNemarExact, AgreesWithAPublishedLargeSample) {
  const double p = McNemarExact({150, 86});
  const double chi_square_p = std::erfc(4.166 / std::sqrt(2.0));
  EXPECT_NEAR(p / chi_square_p, 1, 0.35);
  const auto odds = MatchedOddsRatio({150, 86});
  EXPECT_NEAR(odds->ratio, 0.573, 5e-4);
  // Wald's interval of the log odds ratio, exp(log .573 +- 1.96 sqrt(1/86 + 1/150)).
  EXPECT_NEAR(odds->interval.low, 0.440, 0.01);
  EXPECT_NEAR(odds->interval.high, 0.747, 0.015);
}

// Clopper and Pearson for none of n: the share is at most 1 - 0.025^(1/n).
TEST(MatchedOddsRatio, ExactIfOneCountIsZero) {
  const auto odds = MatchedOddsRatio({10, 0});
  const double max_share = 1 - std::pow(0.025, 0.1);
  EXPECT_EQ(odds->ratio, 0);
  EXPECT_EQ(odds->interval.low, 0);
  EXPECT_NEAR(odds->interval.high, max_share / (1 - max_share), 1e-9);
  EXPECT_EQ(MatchedOddsRatio({0, 10})->ratio, kInfinity);
  EXPECT_EQ(MatchedOddsRatio({0, 10})->interval.high, kInfinity);
  EXPECT_FALSE(MatchedOddsRatio({0, 0}));
}

// With one outcome per scene, exchanging the labels gives the binomial of McNemar's test.
TEST(PairedRateTest, EqualsMcNemarForOneOutcomePerScene) {
  for (const Discordance d : {Discordance{1, 7}, Discordance{3, 8}, Discordance{4, 5}}) {
    std::vector<Cluster> before(30, {1, 1}), after(30, {1, 1});
    for (int i = 0; i < d.before_only; ++i) after[i].hits = 0;
    for (int i = 0; i < d.after_only; ++i) before[10 + i].hits = 0;
    EXPECT_NEAR(PairedRateTest(before, after), McNemarExact(d), 1e-12);
  }
}

// Computes the statistic from its definition for all 2^n labellings, and compares it with the
// incremental sums.
TEST(PairedRateTest, EqualsEnumeration) {
  Rng rng(3);
  const ScenePairs pairs = DrawPairs(9, 0.6, 0.2, 0.2, 0.5, UniformSize(1, 8), rng);
  const auto size = [&](int pattern) {
    double h[2] = {0, 0}, t[2] = {0, 0};
    const auto of = [&](int k, size_t i) {
      return ((pattern >> i & 1) ^ k) ? pairs.after[i] : pairs.before[i];
    };
    for (size_t i = 0; i < pairs.before.size(); ++i) {
      for (int k = 0; k < 2; ++k) {
        h[k] += of(k, i).hits;
        t[k] += of(k, i).samples;
      }
    }
    double variance = 0;
    for (size_t i = 0; i < pairs.before.size(); ++i) {
      const double a = (of(0, i).hits - h[0] / t[0] * of(0, i).samples) / t[0];
      const double b = (of(1, i).hits - h[1] / t[1] * of(1, i).samples) / t[1];
      variance += (b - a) * (b - a);
    }
    return std::abs(h[1] / t[1] - h[0] / t[0]) / std::sqrt(variance);
  };
  int as_large = 0;
  for (int pattern = 0; pattern < 512; ++pattern) as_large += size(pattern) >= size(0) - 1e-9;
  EXPECT_NEAR(PairedRateTest(pairs.before, pairs.after), as_large / 512.0, 1e-12);
}

TEST(PairedRateTest, EqualOrEmptyRunsDoNotDiffer) {
  const std::vector<Cluster> scenes(50, {3, 4}), nothing(50);
  EXPECT_EQ(PairedRateTest(scenes, scenes), 1);
  EXPECT_EQ(PairedRateTest(nothing, nothing), 1);
  EXPECT_THROW(PairedRateTest(scenes, std::vector<Cluster>(3)), std::logic_error);
}

// Better in each of 50 scenes: the p-value is the smallest that the number of permutations allows.
TEST(PairedRateTest, ClearDifferenceHasTheSmallestPValue) {
  const std::vector<Cluster> before(50, {3, 10}), after(50, {5, 10});
  EXPECT_NEAR(PairedRateTest(before, after, 999), 1e-3, 1e-9);
  EXPECT_EQ(PairedRateTest(before, after, 999, 4), PairedRateTest(before, after, 999, 4));
}

// Equal rates in all scenes of a run have no spread. Two scenes have four labellings. Two
// labellings are as extreme as the found one.
TEST(PairedRateTest, DifferenceWithoutSpreadIsNotImpossible) {
  const std::vector<Cluster> before{{1, 2}, {1, 2}}, after{{2, 2}, {6, 6}};
  EXPECT_EQ(PairedRateTest(before, after), 0.5);
  const std::vector<Cluster> none(6, {0, 5}), all(6, {5, 5});
  EXPECT_EQ(PairedRateTest(none, all), 2 / 64.0);
}

using PairTest = std::function<double(const ScenePairs& pairs)>;

double FalseAlarms(int experiments, int scenes, const SceneSize& size, double own,
                   const PairTest& test) {
  Rng rng(17);
  int alarms = 0;
  for (int k = 0; k < experiments; ++k) {
    alarms += test(DrawPairs(scenes, 0.7, 0.3, 0, own, size, rng)) <= 0.05;
  }
  return alarms / static_cast<double>(experiments);
}

// Three standard errors of the simulation above the level are allowed.
double MaxAlarmRate(int experiments) { return 0.05 + 3 * std::sqrt(0.05 * 0.95 / experiments); }

TEST(McNemarExact, FalseAlarmRateIsAtMostTheLevel) {
  const PairTest mcnemar = [](const ScenePairs& pairs) {
    Discordance d;
    for (size_t i = 0; i < pairs.before.size(); ++i) {
      d.before_only += pairs.before[i].hits > pairs.after[i].hits;
      d.after_only += pairs.after[i].hits > pairs.before[i].hits;
    }
    return McNemarExact(d);
  };
  for (const int scenes : {20, 40, 100}) {
    EXPECT_LE(FalseAlarms(10000, scenes, ConstantSize(1), 1, mcnemar), MaxAlarmRate(10000))
        << scenes;
  }
}

TEST(PairedRateTest, FalseAlarmRateIsAtMostTheLevel) {
  constexpr int kExperiments = 2000;
  const PairTest permutation_test = [](const ScenePairs& pairs) {
    return PairedRateTest(pairs.before, pairs.after, 199);
  };
  for (const int scenes : {20, 40, 100}) {
    const double alarms =
        FalseAlarms(kExperiments, scenes, UniformSize(1, 12), 0.5, permutation_test);
    EXPECT_LE(alarms, MaxAlarmRate(kExperiments)) << scenes;
    EXPECT_GE(alarms, 0.03) << scenes << ": the test is too conservative";
  }
}

// Equal rates with unequal spread: half of the scenes at 1 and half at 0, against 0.5 in every
// scene.
TEST(PairedRateTest, KeepsItsLevelWithUnequalSpread) {
  constexpr int kExperiments = 2000;
  Rng rng(19);
  int alarms = 0;
  for (int k = 0; k < kExperiments; ++k) {
    ScenePairs pairs;
    for (int i = 0; i < 40; ++i) {
      pairs.before.push_back(DrawScene(0.5, 12, rng));
      pairs.after.push_back(DrawScene(rng.Uniform() < 0.5, 12, rng));
    }
    alarms += PairedRateTest(pairs.before, pairs.after, 199) <= 0.05;
  }
  EXPECT_LE(alarms, MaxAlarmRate(kExperiments) * kExperiments);
}

ValueClusters DrawErrors(double scale, const std::vector<double>& scenes, Rng& rng) {
  ValueClusters errors;
  for (const double scene : scenes) {
    auto& values = errors.emplace_back(1 + rng.Index(8));
    for (double& value : values) value = scale * std::exp(scene + 0.4 * rng.Normal());
  }
  return errors;
}

TEST(PairedMedianTest, KeepsItsLevelAndDetectsADifference) {
  constexpr int kExperiments = 400;
  Rng rng(23);
  int alarms = 0, found = 0, covered = 0;
  for (int k = 0; k < kExperiments; ++k) {
    std::vector<double> scenes(40);
    for (double& scene : scenes) scene = 0.5 * rng.Normal();
    const ValueClusters a = DrawErrors(1, scenes, rng), b = DrawErrors(1, scenes, rng);
    const ValueClusters halved = DrawErrors(0.6, scenes, rng);
    alarms += PairedMedianTest(a, b, 99) <= 0.05;
    found += PairedMedianTest(a, halved, 99) <= 0.05;
    const Interval interval = PairedMedianInterval(a, halved, 0.95, 300);
    covered += interval.low <= -0.4 && -0.4 <= interval.high;
  }
  EXPECT_LE(alarms, MaxAlarmRate(kExperiments) * kExperiments);
  EXPECT_GT(found, 0.95 * kExperiments);
  EXPECT_NEAR(covered / double(kExperiments), 0.95, 0.035);
}

// (1.959964 + 0.841621)^2 = 7.8489 times (.5 / .1)^2, plus 1.92.
TEST(ScenesNeeded, EqualHandComputedValues) {
  EXPECT_EQ(ScenesNeeded(0.1, 0.5), 199);
  EXPECT_EQ(ScenesNeeded(-0.1, 0.5), 199);
  EXPECT_FALSE(ScenesNeeded(0, 0.5));
  // Connor: (1.959964 sqrt(.3) + .841621 sqrt(.3 - .01))^2 / .01 = 233.1, plus 10.
  EXPECT_EQ(ScenesNeededForMcNemar(0.1, 0.3), 244);
  EXPECT_FALSE(ScenesNeededForMcNemar(0, 0.3));
}

// Power of McNemar's exact test without simulation. The number of discordant scenes is binomial,
// and so is the number of them in which only `after` succeeds.
double McNemarPower(int scenes, double difference, double discordant) {
  const auto binomial = [](int n, double p) {
    std::vector<double> of(n + 1);
    for (int k = 0; k <= n; ++k) {
      of[k] = std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) +
                       k * std::log(p) + (n - k) * std::log1p(-p));
    }
    return of;
  };
  const std::vector<double> of_all = binomial(scenes, discordant);
  double power = 0;
  for (int n = 1; n <= scenes; ++n) {
    const std::vector<double> of = binomial(n, 0.5 + 0.5 * difference / discordant);
    for (int k = 0; k <= n; ++k) {
      if (McNemarExact({n - k, k}) <= 0.05) power += of_all[n] * of[k];
    }
  }
  return power;
}

TEST(ScenesNeeded, GiveTheRequestedPower) {
  EXPECT_NEAR(McNemarPower(*ScenesNeededForMcNemar(0.1, 0.3), 0.1, 0.3), 0.8, 0.02);
  EXPECT_NEAR(McNemarPower(*ScenesNeededForMcNemar(0.2, 0.3), 0.2, 0.3), 0.8, 0.04);
  // The permutation test, with the number of scenes that the spread of a large pilot requires.
  constexpr int kExperiments = 500;
  Rng rng(29);
  const auto draw = [&](int scenes) {
    return DrawPairs(scenes, 0.5, 0.3, 0.1, 0.3, UniformSize(1, 12), rng);
  };
  const ScenePairs pilot = draw(20000);
  const int needed = *ScenesNeeded(0.1, DeviationOfRise(pilot.before, pilot.after));
  int found = 0;
  for (int k = 0; k < kExperiments; ++k) {
    const ScenePairs pairs = draw(needed);
    found += PairedRateTest(pairs.before, pairs.after, 199) <= 0.05;
  }
  EXPECT_NEAR(found / double(kExperiments), 0.8, 0.06) << needed << " scenes";
}

}  // namespace
}  // namespace pickbed::tests
