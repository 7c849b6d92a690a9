#include "eval/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "scenes/random.h"

namespace pickbed {
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

TEST(WilsonInterval, KnowsNothingWithoutAttempts) {
  const Interval none = WilsonInterval(0, 0);
  EXPECT_EQ(none.low, 0);
  EXPECT_EQ(none.high, 1);
}

TEST(WilsonInterval, MirrorsWhenSuccessAndFailureSwap) {
  for (int k = 0; k <= 12; ++k) {
    const Interval a = WilsonInterval(k, 12), b = WilsonInterval(12 - k, 12);
    EXPECT_NEAR(a.low, 1 - b.high, 1e-12);
    EXPECT_LE(a.low, k / 12.0 + 1e-12);
    EXPECT_GE(a.high, k / 12.0 - 1e-12);
  }
}

// Units that agree within themselves: the interval must be as wide as that of so many single tries.
TEST(ClusterBootstrap, TriesOfOneUnitAreNotIndependent) {
  std::vector<Cluster> clusters;
  for (int i = 0; i < 40; ++i) clusters.push_back({i % 2 ? 25 : 0, 25});
  const Interval clustered = ClusterBootstrap(clusters);
  const Interval single = WilsonInterval(20, 40), many = WilsonInterval(500, 1000);
  EXPECT_NEAR(clustered.high - clustered.low, single.high - single.low, 0.03);
  EXPECT_GT(clustered.high - clustered.low, 3 * (many.high - many.low));
}

// 95 % intervals hold the truth in about 95 % of experiments, here with rates that differ by unit.
TEST(ClusterBootstrap, CoversTheTruth) {
  constexpr int kExperiments = 400;
  Rng rng(5);
  int covered = 0;
  for (int experiment = 0; experiment < kExperiments; ++experiment) {
    std::vector<Cluster> clusters(60);
    for (Cluster& cluster : clusters) {
      const double rate = rng.Uniform(0.5, 0.9);
      cluster.tries = 10;
      for (int i = 0; i < cluster.tries; ++i) cluster.hits += rng.Uniform(0, 1) < rate;
    }
    const Interval interval = ClusterBootstrap(clusters, 0.95, 400, experiment);
    covered += interval.low <= 0.7 && 0.7 <= interval.high;
  }
  EXPECT_NEAR(covered / static_cast<double>(kExperiments), 0.94, 0.035);
}

TEST(ClusterBootstrap, KnowsNothingWithoutTries) {
  const std::vector<Cluster> empty{{0, 0}, {0, 0}};
  EXPECT_EQ(ClusterBootstrap(empty).low, 0);
  EXPECT_EQ(ClusterBootstrap(empty).high, 1);
}

// Rates that differ much from unit to unit but by the same in each pair: pairing keeps the units'
// own spread out of the interval.
TEST(PairedBootstrap, PairsTakeOutWhatUnitsHaveInCommon) {
  std::vector<Cluster> before, after;
  for (int i = 0; i < 40; ++i) {
    before.push_back({i % 2 ? 50 : 10, 100});
    after.push_back({before.back().hits + 20, 100});
  }
  const Interval rise = PairedBootstrap(before, after);
  EXPECT_NEAR(rise.low, 0.2, 1e-12);
  EXPECT_NEAR(rise.high, 0.2, 1e-12);
  std::vector<Cluster> turned(after);
  std::rotate(turned.begin(), turned.begin() + 1, turned.end());
  const Interval unpaired = PairedBootstrap(before, turned);
  EXPECT_GT(unpaired.high - unpaired.low, 0.1);
}

TEST(PairedBootstrap, CoversTheTruth) {
  constexpr int kExperiments = 400;
  Rng rng(6);
  int covered = 0;
  for (int experiment = 0; experiment < kExperiments; ++experiment) {
    std::vector<Cluster> before(60), after(60);
    for (size_t i = 0; i < before.size(); ++i) {
      const double rate = rng.Uniform(0.4, 0.8);
      before[i].tries = after[i].tries = 10;
      for (int k = 0; k < 10; ++k) {
        before[i].hits += rng.Uniform(0, 1) < rate;
        after[i].hits += rng.Uniform(0, 1) < rate + 0.1;
      }
    }
    const Interval rise = PairedBootstrap(before, after, 0.95, 400, experiment);
    covered += rise.low <= 0.1 && 0.1 <= rise.high;
  }
  EXPECT_NEAR(covered / static_cast<double>(kExperiments), 0.94, 0.035);
}

TEST(PairedBootstrap, KnowsNothingWithoutTriesAndNeedsPairs) {
  const std::vector<Cluster> none{{0, 0}}, one{{1, 2}};
  EXPECT_EQ(PairedBootstrap(none, one).low, -1);
  EXPECT_EQ(PairedBootstrap(one, none).high, 1);
  EXPECT_THROW(PairedBootstrap(one, std::vector<Cluster>{{1, 2}, {1, 2}}), std::logic_error);
}

}  // namespace
}  // namespace pickbed
