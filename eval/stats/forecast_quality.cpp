#include "eval/stats/forecast_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

// Sums over the forecasts of one cluster, or of several.
struct ForecastSums {
  struct Range {
    double probability = 0;
    int hits = 0, count = 0;
  };
  std::array<Range, kReliabilityRanges> ranges{};
  double squared_error = 0;
  int count = 0;

  void Add(const ForecastSums& other) {
    for (size_t r = 0; r < ranges.size(); ++r) {
      ranges[r].probability += other.ranges[r].probability;
      ranges[r].hits += other.ranges[r].hits;
      ranges[r].count += other.ranges[r].count;
    }
    squared_error += other.squared_error;
    count += other.count;
  }
  double CalibrationError() const {
    double error = 0;
    for (const Range& range : ranges) error += std::abs(range.probability - range.hits);
    return count > 0 ? error / count : 0;
  }
  double Brier() const { return count > 0 ? squared_error / count : 0; }
};

int RangeOf(double probability) {
  return std::clamp(static_cast<int>(probability * kReliabilityRanges), 0, kReliabilityRanges - 1);
}

std::vector<ForecastSums> SumsOf(const ForecastClusters& clusters) {
  std::vector<ForecastSums> sums(clusters.size());
  for (size_t c = 0; c < clusters.size(); ++c) {
    for (const ForecastOutcome& forecast : clusters[c]) {
      ForecastSums::Range& range = sums[c].ranges[RangeOf(forecast.probability)];
      range.probability += forecast.probability;
      range.hits += forecast.happened;
      ++range.count;
      const double error = forecast.probability - (forecast.happened ? 1 : 0);
      sums[c].squared_error += error * error;
      ++sums[c].count;
    }
  }
  return sums;
}

ForecastSums Total(const std::vector<ForecastSums>& sums) {
  ForecastSums total;
  for (const ForecastSums& sum : sums) total.Add(sum);
  return total;
}

constexpr double kTail = 0.025;  // of each side of an interval

// Basic bootstrap interval of `value` from the values of the draws.
Interval BasicInterval(double value, std::vector<double> draws) {
  std::sort(draws.begin(), draws.end());
  const auto at = [&](double share) {
    return draws[static_cast<size_t>(share * static_cast<double>(draws.size() - 1) + 0.5)];
  };
  return {2 * value - at(1 - kTail), 2 * value - at(kTail)};
}

using Quality = std::array<double, 2>;  // calibration error, Brier score

// Calls `quality` for all clusters in order, and for draws of them. `floor`: smallest end.
ForecastQuality WithIntervals(int clusters, int resamples, uint64_t seed, double floor,
                              const std::function<Quality(const std::vector<int>&)>& quality) {
  std::vector<int> drawn(clusters);
  for (int i = 0; i < clusters; ++i) drawn[i] = i;
  const Quality value = quality(drawn);
  ForecastQuality result{{value[0]}, {value[1]}};
  if (clusters < kMinBinsOfInterval || resamples < 1) return result;
  Rng rng(seed);
  std::array<std::vector<double>, 2> draws;
  for (int k = 0; k < resamples; ++k) {
    for (int& index : drawn) index = rng.Index(clusters);
    const Quality of_draw = quality(drawn);
    for (size_t q = 0; q < draws.size(); ++q) draws[q].push_back(of_draw[q]);
  }
  const auto interval = [&](size_t q) {
    const Interval basic = BasicInterval(value[q], draws[q]);
    return Interval{std::max(floor, basic.low), std::max(floor, basic.high)};
  };
  result.calibration_error.ci95 = interval(0);
  result.brier.ci95 = interval(1);
  return result;
}

ForecastSums Drawn(const std::vector<ForecastSums>& sums, const std::vector<int>& drawn) {
  ForecastSums total;
  for (const int index : drawn) total.Add(sums[index]);
  return total;
}

// Returns the calibration error that calibrated forecasts exceed in kTail of all samples: the
// outcomes are drawn with the forecast probabilities.
double ErrorOfCalibrated(const ForecastClusters& clusters, int resamples, uint64_t seed) {
  Rng rng = Rng::Derive(seed, 0, "calibrated");
  std::vector<double> errors;
  for (int k = 0; k < resamples; ++k) {
    ForecastClusters drawn = clusters;
    for (auto& cluster : drawn) {
      for (ForecastOutcome& forecast : cluster) {
        forecast.happened = rng.Uniform() < forecast.probability;
      }
    }
    errors.push_back(Total(SumsOf(drawn)).CalibrationError());
  }
  std::sort(errors.begin(), errors.end());
  return errors[static_cast<size_t>((1 - kTail) * static_cast<double>(errors.size() - 1) + 0.5)];
}

}  // namespace

std::vector<ReliabilityPoint> ReliabilityOf(const ForecastClusters& clusters) {
  const std::vector<ForecastSums> sums = SumsOf(clusters);
  const ForecastSums total = Total(sums);
  std::vector<ReliabilityPoint> points;
  for (int r = 0; r < kReliabilityRanges; ++r) {
    if (total.ranges[r].count == 0) continue;
    std::vector<Cluster> by_cluster;
    for (const ForecastSums& sum : sums) {
      by_cluster.push_back({sum.ranges[r].hits, sum.ranges[r].count});
    }
    points.push_back(
        {total.ranges[r].probability / total.ranges[r].count, ClusterRate(by_cluster)});
  }
  return points;
}

ForecastQuality QualityOf(const ForecastClusters& clusters, int resamples, uint64_t seed) {
  const std::vector<ForecastSums> sums = SumsOf(clusters);
  ForecastQuality quality = WithIntervals(static_cast<int>(sums.size()), resamples, seed, 0,
                                          [&](const std::vector<int>& drawn) -> Quality {
                                            const ForecastSums total = Drawn(sums, drawn);
                                            return {total.CalibrationError(), total.Brier()};
                                          });
  ClusterValue& error = quality.calibration_error;
  if (error.ci95.is_known() && error.value <= ErrorOfCalibrated(clusters, resamples, seed)) {
    error.ci95.low = 0;
  }
  return quality;
}

ForecastQuality QualityDifference(const ForecastClusters& before, const ForecastClusters& after,
                                  int resamples, uint64_t seed) {
  if (before.size() != after.size()) throw std::logic_error("other clusters before and after");
  const std::vector<ForecastSums> a = SumsOf(before), b = SumsOf(after);
  return WithIntervals(
      static_cast<int>(a.size()), resamples, seed, -kInfinity,
      [&](const std::vector<int>& drawn) -> Quality {
        const ForecastSums was = Drawn(a, drawn), is = Drawn(b, drawn);
        return {is.CalibrationError() - was.CalibrationError(), is.Brier() - was.Brier()};
      });
}

}  // namespace pickbed::eval
