#include "eval/stats/isotonic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

TEST(PoolAdjacentViolators, RisingRatesStayApart) {
  const auto blocks = PoolAdjacentViolators(
      std::vector<ScoredOutcome>{{2, true}, {1, false}, {2, true}, {1, true}, {0, false}});
  ASSERT_THAT(blocks, SizeIs(3));
  EXPECT_EQ(blocks[0].rate, 0);
  EXPECT_EQ(blocks[1].rate, 0.5);
  EXPECT_EQ(blocks[2].rate, 1);
  EXPECT_EQ(blocks[1].first, 1);
  EXPECT_EQ(blocks[1].last, 1);
  EXPECT_EQ(blocks[2].samples, 2);
}

TEST(PoolAdjacentViolators, AFallIsPooledBackwards) {
  // Rates 0, 1, 1/2, 0: the last three are pooled.
  const auto blocks = PoolAdjacentViolators(
      std::vector<ScoredOutcome>{{-3, false}, {-2, true}, {-1, true}, {-1, false}, {0, false}});
  ASSERT_THAT(blocks, SizeIs(2));
  EXPECT_EQ(blocks[1].first, -2);
  EXPECT_EQ(blocks[1].last, 0);
  EXPECT_EQ(blocks[1].rate, 0.5);
  EXPECT_THAT(PoolAdjacentViolators({}), IsEmpty());
}

double SquaredError(const std::vector<ScoredOutcome>& outcomes, const std::vector<double>& rates) {
  double sum = 0;
  for (size_t i = 0; i < outcomes.size(); ++i) {
    sum += std::pow(rates[i] - (outcomes[i].success ? 1 : 0), 2);
  }
  return sum;
}

// The minimax formula of isotonic regression (Barlow et al. 1972): the fitted value at i is the
// maximum over s <= i of the minimum over t >= i of the mean of s..t.
TEST(PoolAdjacentViolators, EqualsTheMinimaxFormula) {
  Rng rng(8);
  for (int round = 0; round < 20; ++round) {
    std::vector<ScoredOutcome> outcomes;
    for (int i = 0; i < 30; ++i) outcomes.push_back({double(i), rng.Uniform() < i / 30.0});
    std::vector<double> fitted, expected;
    for (const IsotonicBlock& block : PoolAdjacentViolators(outcomes)) {
      fitted.insert(fitted.end(), block.samples, block.rate);
    }
    for (int i = 0; i < 30; ++i) {
      double best = 0;
      for (int s = 0; s <= i; ++s) {
        double lowest = 1, hits = 0;
        for (int t = s; t < 30; ++t) {
          hits += outcomes[t].success;
          if (t >= i) lowest = std::min(lowest, hits / (t - s + 1));
        }
        best = std::max(best, lowest);
      }
      expected.push_back(best);
    }
    ASSERT_EQ(fitted.size(), expected.size());
    for (int i = 0; i < 30; ++i) EXPECT_NEAR(fitted[i], expected[i], 1e-12);
    EXPECT_LE(SquaredError(outcomes, fitted), SquaredError(outcomes, std::vector<double>(30, 0.5)));
  }
}

}  // namespace
}  // namespace pickbed::tests
