#include "eval/stats/roc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

std::vector<ScoredOutcome> Outcomes(const std::vector<double>& successes,
                                    const std::vector<double>& failures) {
  std::vector<ScoredOutcome> outcomes;
  for (const double score : successes) outcomes.push_back({score, true});
  for (const double score : failures) outcomes.push_back({score, false});
  return outcomes;
}

// Normal scores of unit variance whose means differ by `apart`.
std::vector<ScoredOutcome> Binormal(double apart, int each, Rng& rng) {
  std::vector<ScoredOutcome> outcomes;
  for (int i = 0; i < each; ++i) {
    outcomes.push_back({rng.Normal() + apart, true});
    outcomes.push_back({rng.Normal(), false});
  }
  return outcomes;
}

double BinormalAuc(double apart) { return 0.5 * std::erfc(-apart / 2); }

TEST(Auc, CountsPairsAndTiesAsHalf) {
  EXPECT_DOUBLE_EQ(Auc(Outcomes({3, 1}, {2, 0})).auc, 0.75);
  EXPECT_DOUBLE_EQ(Auc(Outcomes({2, 2}, {2, 2, 2})).auc, 0.5);
  EXPECT_DOUBLE_EQ(Auc(Outcomes({2, 3}, {2, 1})).auc, 0.875);
  EXPECT_DOUBLE_EQ(Auc(Outcomes({5, 6}, {1, 2})).auc, 1);
  EXPECT_DOUBLE_EQ(Auc(Outcomes({1, 2}, {5, 6})).auc, 0);
}

TEST(Auc, EqualsBruteForcePairCount) {
  Rng rng(5);
  for (int round = 0; round < 20; ++round) {
    std::vector<ScoredOutcome> outcomes;
    for (int i = 0; i < 40; ++i) outcomes.push_back({double(rng.Index(8)), rng.Uniform() < 0.3});
    double sum = 0, pairs = 0;
    for (const auto& a : outcomes) {
      for (const auto& b : outcomes) {
        if (!a.success || b.success) continue;
        sum += a.score > b.score ? 1 : a.score == b.score ? 0.5 : 0;
        ++pairs;
      }
    }
    ASSERT_GT(pairs, 0);
    EXPECT_NEAR(Auc(outcomes).auc, sum / pairs, 1e-12);
  }
}

TEST(Auc, NormalScoresGiveTheNormalIntegral) {
  Rng rng(1);
  for (const double apart : {0.0, 0.5, 1.0, 2.0}) {
    EXPECT_NEAR(Auc(Binormal(apart, 40000, rng)).auc, BinormalAuc(apart), 0.006) << apart;
  }
}

TEST(Auc, IntervalIsDeLongOnTheLogit) {
  // Successes {3, 1} against failures {2, 0}: placements 1 and 0.5 of the successes, 0.5 and 1 of
  // the failures; variance 0.125 / 2 + 0.125 / 2 = 0.125.
  const AucResult result = Auc(Outcomes({3, 1}, {2, 0}));
  const double half = 1.959963985 * std::sqrt(0.125) / (0.75 * 0.25);
  EXPECT_NEAR(result.interval.low, 1 / (1 + std::exp(-(std::log(3.0) - half))), 1e-9);
  EXPECT_NEAR(result.interval.high, 1 / (1 + std::exp(-(std::log(3.0) + half))), 1e-9);
  EXPECT_EQ(result.successes, 2);
  EXPECT_EQ(result.failures, 2);
}

TEST(Auc, IntervalCoversTheTruthIn95Percent) {
  Rng rng(2);
  const int rounds = 1500;
  for (const double apart : {0.5, 1.5}) {
    int held = 0;
    for (int i = 0; i < rounds; ++i) {
      const Interval interval = Auc(Binormal(apart, 50, rng)).interval;
      held += interval.low <= BinormalAuc(apart) && BinormalAuc(apart) <= interval.high;
    }
    EXPECT_NEAR(double(held) / rounds, 0.95, 0.025) << apart;
  }
}

TEST(Auc, FewSeparatedScoresLeaveAWideInterval) {
  const AucResult few = Auc(Outcomes({5, 6, 7}, {1, 2, 3}));
  EXPECT_DOUBLE_EQ(few.interval.high, 1);
  EXPECT_LT(few.interval.low, 0.6);
  std::vector<double> successes(100, 1.0), failures(100, 0.0);
  EXPECT_GT(Auc(Outcomes(successes, failures)).interval.low, 0.95);
}

TEST(Auc, OnlyOneOutcomeGivesNoInformation) {
  const AucResult none = Auc(Outcomes({1, 2}, {}));
  EXPECT_DOUBLE_EQ(none.auc, 0.5);
  EXPECT_DOUBLE_EQ(none.interval.low, 0);
  EXPECT_DOUBLE_EQ(none.interval.high, 1);
}

TEST(Auc, DifferenceUsesTheCorrelationOfScores) {
  Rng rng(3);
  const int rounds = 800;
  int held = 0;
  double paired_width = 0, apart_width = 0;
  for (int i = 0; i < rounds; ++i) {
    // Both scores contain the same signal with independent noise; b has more noise.
    std::vector<ScoredOutcome> a, b;
    for (int k = 0; k < 120; ++k) {
      const bool success = k % 2 == 0;
      const double signal = rng.Normal() + success;
      a.push_back({signal + 0.3 * rng.Normal(), success});
      b.push_back({signal + 0.6 * rng.Normal(), success});
    }
    const double truth = BinormalAuc(1 / std::sqrt(1.09)) - BinormalAuc(1 / std::sqrt(1.36));
    const AucDifference d = CompareAuc(a, b);
    held += d.interval.low <= truth && truth <= d.interval.high;
    paired_width += d.interval.high - d.interval.low;
    const Interval of_a = Auc(a).interval, of_b = Auc(b).interval;
    apart_width += std::hypot(of_a.high - of_a.low, of_b.high - of_b.low);
  }
  EXPECT_NEAR(double(held) / rounds, 0.95, 0.03);
  EXPECT_LT(paired_width, 0.7 * apart_width);
}

TEST(Auc, ScoreDoesNotDifferFromItself) {
  Rng rng(4);
  const auto outcomes = Binormal(1, 50, rng);
  const AucDifference d = CompareAuc(outcomes, outcomes);
  EXPECT_DOUBLE_EQ(d.difference, 0);
  EXPECT_DOUBLE_EQ(d.interval.low, 0);
  EXPECT_DOUBLE_EQ(d.interval.high, 0);
  const AucDifference few = CompareAuc(Outcomes({5, 6}, {1, 2}), Outcomes({7, 9}, {1, 3}));
  EXPECT_EQ(few.difference, 0);
  EXPECT_LT(few.interval.low, -0.3);
  EXPECT_GT(few.interval.high, 0.3);
  auto other = outcomes;
  other[0].success = !other[0].success;
  EXPECT_THROW(CompareAuc(outcomes, other), std::logic_error);
}

TEST(Auc, CopiesWithinAClusterDoNotNarrowTheInterval) {
  Rng rng(6);
  const auto outcomes = Binormal(1, 60, rng);
  std::vector<std::vector<ScoredOutcome>> clusters;
  std::vector<ScoredOutcome> copies;
  for (const ScoredOutcome& outcome : outcomes) {
    clusters.emplace_back(9, outcome);
    copies.insert(copies.end(), 9, outcome);
  }
  const Interval once = Auc(outcomes).interval, naive = Auc(copies).interval;
  const Interval clustered = ClusterBootstrapAuc(clusters);
  EXPECT_LT(naive.high - naive.low, 0.45 * (once.high - once.low));
  EXPECT_NEAR(clustered.high - clustered.low, once.high - once.low, 0.25 * (once.high - once.low));
  // A score minus itself is zero. Minus a score without noise, it varies like itself.
  const Interval nothing = ClusterBootstrapAucDifference(clusters, clusters);
  EXPECT_EQ(nothing.low, 0);
  EXPECT_EQ(nothing.high, 0);
  auto certain = clusters;
  for (auto& cluster : certain) {
    for (ScoredOutcome& outcome : cluster) outcome.score = outcome.success ? 1 : 0;
  }
  const Interval less = ClusterBootstrapAucDifference(clusters, certain);
  EXPECT_NEAR(less.low, clustered.low - 1, 1e-12);
  EXPECT_NEAR(less.high, clustered.high - 1, 1e-12);
  const Interval again = ClusterBootstrapAuc(clusters);
  EXPECT_DOUBLE_EQ(again.low, clustered.low);
  EXPECT_DOUBLE_EQ(again.high, clustered.high);
}

TEST(ClusterBootstrapAuc, WidthIsPositiveIfEveryDrawSeparates) {
  const OutcomeClusters separated{Outcomes({5, 6}, {1}), Outcomes({7}, {2}), Outcomes({8}, {0, 1}),
                                  Outcomes({9}, {3}), Outcomes({6}, {2})};
  const Interval interval = ClusterBootstrapAuc(separated);
  EXPECT_EQ(interval.high, 1);
  EXPECT_DOUBLE_EQ(interval.low, WilsonInterval(5, 5).low);
}

TEST(ClusterBootstrapAuc, FewClustersLeaveItUnknown) {
  const OutcomeClusters four(4, Outcomes({5, 6}, {1, 7}));
  EXPECT_FALSE(ClusterBootstrapAuc(four).is_known());
  EXPECT_FALSE(ClusterBootstrapAucDifference(four, four).is_known());
  AucResult auc = Auc(four[0]);
  auc.interval = ClusterBootstrapAuc(four);
  EXPECT_EQ(AucText(auc), "0.500 (too few bins)");
}

TEST(ClusterBootstrapAuc, OnlyOneOutcomeGivesTheWholeRange) {
  const OutcomeClusters all_well(5, Outcomes({5, 6}, {}));
  const Interval auc = ClusterBootstrapAuc(all_well);
  EXPECT_EQ(auc.low, 0);
  EXPECT_EQ(auc.high, 1);
  const Interval difference = ClusterBootstrapAucDifference(all_well, all_well);
  EXPECT_EQ(difference.low, -1);
  EXPECT_EQ(difference.high, 1);
  EXPECT_FALSE(Auc(all_well[0]).is_known());
}

TEST(AucText, HasThreeDecimalsAndTheInterval) {
  AucResult auc;
  auc.auc = 0.8125;
  auc.interval = {0.7, 0.8999};
  EXPECT_EQ(AucText(auc), "0.812 [0.700, 0.900]");
}

}  // namespace
}  // namespace pickbed::tests
