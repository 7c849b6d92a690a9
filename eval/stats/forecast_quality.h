#pragma once

// Quality of predicted probabilities: calibration error and Brier score, with intervals over bins.

#include <cstdint>
#include <vector>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

// A predicted probability and what happened.
struct ForecastOutcome {
  double probability = 0;
  bool happened = false;
};
// By independent unit (a bin).
using ForecastClusters = std::vector<std::vector<ForecastOutcome>>;

// Number of forecasts with about the same probability, and their rate.
struct ReliabilityPoint {
  double mean_probability = 0;
  ReportRate rate;  // of what happened
};
// Number of ranges of equal width in which forecasts are compared with rates.
inline constexpr int kReliabilityRanges = 10;
// Returns one point per range that has a forecast.
std::vector<ReliabilityPoint> ReliabilityOf(const ForecastClusters& clusters);

// A value with its 95 % interval over clusters.
struct ClusterValue {
  double value = 0;
  Interval ci95 = Interval::Unknown();
};

// Quality of forecasts.
struct ForecastQuality {
  // Expected calibration error over kReliabilityRanges ranges (Naeini, Cooper and Hauskrecht 2015).
  ClusterValue calibration_error;
  ClusterValue brier;  // mean squared difference of probability and outcome (Brier 1950)
};

// Computes the quality. The intervals come from `resamples` draws of clusters with replacement.
// They are basic bootstrap intervals (Davison and Hinkley 1997, sec. 5.2): the calibration error of
// a sample is larger than the true one, and the draws have that bias once more, so that it is
// subtracted. An end below 0 is 0. The calibration error may be 0 if it is no larger than in 97.5 %
// of samples whose outcomes have the forecast probabilities. Unknown with fewer than
// kMinBinsOfInterval clusters. Equal seeds give equal intervals.
ForecastQuality QualityOf(const ForecastClusters& clusters, int resamples = 1000,
                          uint64_t seed = 0);

// Quality of `after` minus quality of `before`, on the same clusters. The intervals are as above.
// Throws std::logic_error if the numbers of clusters differ.
ForecastQuality QualityDifference(const ForecastClusters& before, const ForecastClusters& after,
                                  int resamples = 1000, uint64_t seed = 0);

}  // namespace pickbed::eval
