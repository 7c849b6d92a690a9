#include "eval/statistics.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "scenes/random.h"

namespace pickbed {

Interval WilsonInterval(int successes, int attempts, double confidence) {
  if (attempts <= 0) return {0, 1};
  const double z = boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
  const double n = attempts;
  const double p = successes / n;
  const double center = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  // The ends are exact at the extremes, where rounding would leave 0.9999999999999999.
  return {successes == 0 ? 0.0 : center - half, successes == attempts ? 1.0 : center + half};
}

Interval ClusterBootstrap(std::span<const Cluster> clusters, double confidence, int resamples,
                          uint64_t seed) {
  const int tries = std::accumulate(clusters.begin(), clusters.end(), 0,
                                    [](int sum, const Cluster& c) { return sum + c.tries; });
  if (tries == 0) return {};
  Rng rng(seed);
  std::vector<double> rates;
  rates.reserve(resamples);
  while (static_cast<int>(rates.size()) < resamples) {
    Cluster sum;
    for (size_t i = 0; i < clusters.size(); ++i) {
      const Cluster& drawn = clusters[rng.Index(static_cast<int>(clusters.size()))];
      sum.hits += drawn.hits;
      sum.tries += drawn.tries;
    }
    if (sum.tries > 0) rates.push_back(static_cast<double>(sum.hits) / sum.tries);
  }
  std::sort(rates.begin(), rates.end());
  const auto at = [&](double share) {
    return rates[static_cast<size_t>(std::lround(share * (resamples - 1)))];
  };
  return {at((1 - confidence) / 2), at((1 + confidence) / 2)};
}

}  // namespace pickbed
