#include "eval/statistics.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "scenes/random.h"

namespace pickbed {
namespace {

int TriesIn(std::span<const Cluster> clusters) {
  return std::accumulate(clusters.begin(), clusters.end(), 0,
                         [](int sum, const Cluster& c) { return sum + c.tries; });
}

double RateOf(const Cluster& sum) { return static_cast<double>(sum.hits) / sum.tries; }

void Add(const Cluster& drawn, Cluster& sum) {
  sum.hits += drawn.hits;
  sum.tries += drawn.tries;
}

Interval Percentiles(std::vector<double> values, double confidence) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
  };
  return {at((1 - confidence) / 2), at((1 + confidence) / 2)};
}

}  // namespace

double TwoSidedZ(double confidence) {
  return boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
}

Interval WilsonInterval(int successes, int attempts, double confidence) {
  if (attempts <= 0) return {0, 1};
  const double z = TwoSidedZ(confidence);
  const double n = attempts;
  const double p = successes / n;
  const double center = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  // The ends are exact at the extremes, where rounding would leave 0.9999999999999999.
  return {successes == 0 ? 0.0 : center - half, successes == attempts ? 1.0 : center + half};
}

Interval ClusterBootstrap(std::span<const Cluster> clusters, double confidence, int resamples,
                          uint64_t seed) {
  if (TriesIn(clusters) == 0) return {};
  Rng rng(seed);
  std::vector<double> rates;
  rates.reserve(resamples);
  while (static_cast<int>(rates.size()) < resamples) {
    Cluster sum;
    for (size_t i = 0; i < clusters.size(); ++i) {
      Add(clusters[rng.Index(static_cast<int>(clusters.size()))], sum);
    }
    if (sum.tries > 0) rates.push_back(RateOf(sum));
  }
  return Percentiles(std::move(rates), confidence);
}

Interval PairedBootstrap(std::span<const Cluster> before, std::span<const Cluster> after,
                         double confidence, int resamples, uint64_t seed) {
  if (before.size() != after.size()) throw std::logic_error("pairs differ in number");
  if (TriesIn(before) == 0 || TriesIn(after) == 0) return {-1, 1};
  Rng rng(seed);
  std::vector<double> rises;
  rises.reserve(resamples);
  while (static_cast<int>(rises.size()) < resamples) {
    Cluster sum_before, sum_after;
    for (size_t i = 0; i < before.size(); ++i) {
      const int unit = rng.Index(static_cast<int>(before.size()));
      Add(before[unit], sum_before);
      Add(after[unit], sum_after);
    }
    if (sum_before.tries == 0 || sum_after.tries == 0) continue;
    rises.push_back(RateOf(sum_after) - RateOf(sum_before));
  }
  return Percentiles(std::move(rises), confidence);
}

}  // namespace pickbed
