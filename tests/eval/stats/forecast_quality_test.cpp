#include "eval/stats/forecast_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Forecasts that are too high by `excess`, in bins of which each is easier or harder.
ForecastClusters Forecasts(double excess, int bins, Rng& rng) {
  ForecastClusters clusters(bins);
  for (auto& cluster : clusters) {
    for (int i = 0; i < 12; ++i) {
      const double p = 0.7 * rng.Uniform();
      cluster.push_back({p + excess, rng.Uniform() < p});
    }
  }
  return clusters;
}

TEST(ForecastQuality, IsComputedByHand) {
  const ForecastClusters clusters{{{0.25, true}, {0.75, true}}, {{0.25, false}, {0.75, true}}};
  const ForecastQuality quality = QualityOf(clusters);
  // Range of 0.25: rate 1/2; of 0.75: rate 1.
  EXPECT_DOUBLE_EQ(quality.calibration_error.value, 0.25);
  EXPECT_DOUBLE_EQ(quality.brier.value, (0.5625 + 0.0625 + 0.0625 + 0.0625) / 4);
  EXPECT_FALSE(quality.brier.ci95.is_known()) << "two bins";
  const auto points = ReliabilityOf(clusters);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_DOUBLE_EQ(points[0].mean_probability, 0.25);
  EXPECT_EQ(points[0].rate.hits, 1);
  EXPECT_EQ(points[1].rate.samples, 2);
  EXPECT_EQ(QualityOf({}).brier.value, 0);
}

TEST(ForecastQuality, TheIntervalsCoverTheTruth) {
  constexpr int kRounds = 60;
  constexpr double kExcess = 0.2;
  int covered = 0, calibrated = 0;
  for (int round = 0; round < kRounds; ++round) {
    Rng rng(round);
    const Interval biased = QualityOf(Forecasts(kExcess, 30, rng), 200).calibration_error.ci95;
    covered += biased.low <= kExcess && kExcess <= biased.high;
    // The true error is 0, but the error of a sample is never 0.
    calibrated += QualityOf(Forecasts(0, 30, rng), 200).calibration_error.ci95.low < 0.01;
  }
  EXPECT_GE(covered, 0.85 * kRounds);
  EXPECT_GE(calibrated, 0.9 * kRounds);
}

TEST(ForecastQuality, ADifferenceHasTheSignOfTheImprovement) {
  Rng rng(4);
  const ForecastClusters after = Forecasts(0, 40, rng);
  ForecastClusters before = after;
  for (auto& cluster : before) {
    for (ForecastOutcome& forecast : cluster) forecast.probability += 0.25;
  }
  const ForecastQuality change = QualityDifference(before, after);
  EXPECT_LT(change.calibration_error.ci95.high, 0);
  EXPECT_LT(change.brier.ci95.high, 0);
  EXPECT_EQ(QualityDifference(after, after).brier.value, 0);
  EXPECT_THROW(QualityDifference(before, {}), std::logic_error);
  const Interval again = QualityDifference(before, after).brier.ci95;
  EXPECT_EQ(again.low, change.brier.ci95.low) << "equal seeds give equal intervals";
}

}  // namespace
}  // namespace pickbed::tests
