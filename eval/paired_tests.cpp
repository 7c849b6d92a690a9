#include "eval/paired_tests.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "scenes/random.h"

namespace pickbed {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostScenes = 1e7;

// Differences that are equal but for rounding count as equal: leaving them out would give too small
// a p value.
constexpr double kRounding = 1e-9;

double OneSidedZ(double share) { return boost::math::quantile(boost::math::normal(), share); }

std::optional<int> WholeScenes(double scenes) {
  if (!(scenes <= kMostScenes)) return std::nullopt;
  return std::max(2, static_cast<int>(std::ceil(scenes)));
}

// Sums over scenes of h and t of two configurations and of their products, from which rates, their
// difference and its linearised variance follow at once when the labels of a scene change.
struct PairSums {
  double h[2] = {0, 0}, t[2] = {0, 0};
  double hh[2] = {0, 0}, ht[2] = {0, 0}, tt[2] = {0, 0};
  double h0h1 = 0, h0t1 = 0, t0h1 = 0, t0t1 = 0;

  void Add(const Cluster& zero, const Cluster& one, double sign) {
    const Cluster* of[2] = {&zero, &one};
    for (int k = 0; k < 2; ++k) {
      const double hits = of[k]->hits, tries = of[k]->tries;
      h[k] += sign * hits;
      t[k] += sign * tries;
      hh[k] += sign * hits * hits;
      ht[k] += sign * hits * tries;
      tt[k] += sign * tries * tries;
    }
    h0h1 += sign * zero.hits * one.hits;
    h0t1 += sign * zero.hits * one.tries;
    t0h1 += sign * zero.tries * one.hits;
    t0t1 += sign * zero.tries * one.tries;
  }

  double Rise() const { return h[1] / t[1] - h[0] / t[0]; }

  // sum((e1 / T1 - e0 / T0)^2) with e = h - p t.
  double Variance() const {
    const double p[2] = {h[0] / t[0], h[1] / t[1]};
    double sum = 0;
    for (int k = 0; k < 2; ++k) {
      sum += (hh[k] - 2 * p[k] * ht[k] + p[k] * p[k] * tt[k]) / (t[k] * t[k]);
    }
    const double cross = h0h1 - p[1] * h0t1 - p[0] * t0h1 + p[0] * p[1] * t0t1;
    return std::max(0.0, sum - 2 * cross / (t[0] * t[1]));
  }

  // |difference| over its standard error.
  double Size() const {
    if (t[0] == 0 || t[1] == 0) return 0;
    const double rise = std::abs(Rise());
    if (rise < kRounding) return 0;
    const double variance = Variance();
    return variance > kRounding * rise * rise ? rise / std::sqrt(variance) : kInfinity;
  }
};

// A value with the scene and configuration that it is of.
struct PooledValue {
  double value = 0;
  int scene = 0;
  int configuration = 0;
};

std::vector<PooledValue> Pooled(const ValueClusters& before, const ValueClusters& after) {
  if (before.size() != after.size()) throw std::logic_error("pairs differ in number");
  std::vector<PooledValue> pool;
  for (size_t i = 0; i < before.size(); ++i) {
    for (const double value : before[i]) pool.push_back({value, static_cast<int>(i), 0});
    for (const double value : after[i]) pool.push_back({value, static_cast<int>(i), 1});
  }
  std::stable_sort(pool.begin(), pool.end(),
                   [](const PooledValue& a, const PooledValue& b) { return a.value < b.value; });
  return pool;
}

// Median of the values for which `configuration` says `wanted`, each as often as its scene counts;
// NaN of none.
double MedianOf(const std::vector<PooledValue>& pool, const std::vector<int>& counts,
                const std::function<int(const PooledValue&)>& configuration, int wanted) {
  long total = 0;
  for (const PooledValue& value : pool) {
    if (configuration(value) == wanted) total += counts[value.scene];
  }
  if (total == 0) return std::numeric_limits<double>::quiet_NaN();
  long passed = 0;
  for (const PooledValue& value : pool) {
    if (configuration(value) != wanted) continue;
    passed += counts[value.scene];
    if (2 * passed >= total) return value.value;
  }
  return pool.back().value;
}

}  // namespace

double McNemarExact(const Discordance& scenes) {
  const int all = scenes.before_only + scenes.after_only;
  if (all == 0) return 1;
  const int fewer = std::min(scenes.before_only, scenes.after_only);
  return std::min(1.0, 2 * boost::math::cdf(boost::math::binomial(all, 0.5), fewer));
}

std::optional<OddsRatio> MatchedOddsRatio(const Discordance& scenes, double confidence) {
  using Binomial = boost::math::binomial_distribution<>;
  const int all = scenes.before_only + scenes.after_only;
  if (all == 0) return std::nullopt;
  const double tail = 0.5 * (1 - confidence);
  const double low = Binomial::find_lower_bound_on_p(all, scenes.after_only, tail);
  const double high = Binomial::find_upper_bound_on_p(all, scenes.after_only, tail);
  const auto odds = [](double share) { return share < 1 ? share / (1 - share) : kInfinity; };
  return OddsRatio{odds(static_cast<double>(scenes.after_only) / all), {odds(low), odds(high)}};
}

double SignFlipTest(int scenes, const FlipStatistic& statistic, int flips, uint64_t seed) {
  std::vector<bool> flipped(scenes, false);
  const double found = statistic(flipped);
  const double least = found - kRounding * std::abs(found);
  if (scenes < 31 && (1L << scenes) <= flips) {
    const long all = 1L << scenes;
    long as_large = 0;
    for (long pattern = 0; pattern < all; ++pattern) {
      for (int i = 0; i < scenes; ++i) flipped[i] = pattern >> i & 1;
      as_large += statistic(flipped) >= least;
    }
    return static_cast<double>(as_large) / static_cast<double>(all);
  }
  Rng rng(seed);
  int as_large = 1;
  for (int k = 0; k < flips; ++k) {
    uint64_t bits = 0;
    for (int i = 0; i < scenes; ++i) {
      if (i % 64 == 0) bits = rng.Next();
      flipped[i] = bits >> i % 64 & 1;
    }
    as_large += statistic(flipped) >= least;
  }
  return static_cast<double>(as_large) / (flips + 1.0);
}

double PairedRateTest(std::span<const Cluster> before, std::span<const Cluster> after, int flips,
                      uint64_t seed) {
  if (before.size() != after.size()) throw std::logic_error("pairs differ in number");
  std::vector<Cluster> a, b;
  PairSums found;
  for (size_t i = 0; i < before.size(); ++i) {
    found.Add(before[i], after[i], 1);
    // Scenes that both did alike stay as they are whatever their labels.
    if (before[i].hits == after[i].hits && before[i].tries == after[i].tries) continue;
    a.push_back(before[i]);
    b.push_back(after[i]);
  }
  const auto size = [&](const std::vector<bool>& flipped) {
    PairSums sums = found;
    for (size_t i = 0; i < a.size(); ++i) {
      if (!flipped[i]) continue;
      sums.Add(a[i], b[i], -1);
      sums.Add(b[i], a[i], 1);
    }
    return sums.Size();
  };
  return SignFlipTest(static_cast<int>(a.size()), size, flips, seed);
}

double PairedMedianTest(const ValueClusters& before, const ValueClusters& after, int flips,
                        uint64_t seed) {
  const std::vector<PooledValue> pool = Pooled(before, after);
  const std::vector<int> once(before.size(), 1);
  const auto size = [&](const std::vector<bool>& flipped) {
    const auto label = [&](const PooledValue& value) {
      return value.configuration ^ static_cast<int>(flipped[value.scene]);
    };
    const double difference = MedianOf(pool, once, label, 1) - MedianOf(pool, once, label, 0);
    // Two infinite medians are alike; labels that leave one without values tell nothing.
    return std::isnan(difference) ? 0 : std::abs(difference);
  };
  return SignFlipTest(static_cast<int>(before.size()), size, flips, seed);
}

Interval PairedMedianInterval(const ValueClusters& before, const ValueClusters& after,
                              double confidence, int resamples, uint64_t seed) {
  const std::vector<PooledValue> pool = Pooled(before, after);
  const auto label = [](const PooledValue& value) { return value.configuration; };
  const int scenes = static_cast<int>(before.size());
  Rng rng(seed);
  std::vector<double> differences;
  for (int k = 0; k < resamples; ++k) {
    std::vector<int> counts(scenes, 0);
    for (int i = 0; i < scenes; ++i) ++counts[rng.Index(scenes)];
    const double difference = MedianOf(pool, counts, label, 1) - MedianOf(pool, counts, label, 0);
    if (!std::isnan(difference)) differences.push_back(difference);
  }
  if (differences.empty()) return {-kInfinity, kInfinity};
  std::sort(differences.begin(), differences.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(differences.size() - 1);
    return differences[static_cast<size_t>(std::lround(place))];
  };
  return {at((1 - confidence) / 2), at((1 + confidence) / 2)};
}

std::optional<int> ScenesNeeded(double difference, double deviation, const WantedPower& wanted) {
  const double z_level = TwoSidedZ(1 - wanted.level);
  const double z = z_level + OneSidedZ(wanted.power);
  return WholeScenes(z * z * deviation * deviation / (difference * difference) +
                     0.5 * z_level * z_level);
}

std::optional<int> ScenesNeededForMcNemar(double difference, double discordant,
                                          const WantedPower& wanted) {
  const double d = std::abs(difference);
  const double root = TwoSidedZ(1 - wanted.level) * std::sqrt(discordant) +
                      OneSidedZ(wanted.power) * std::sqrt(std::max(0.0, discordant - d * d));
  return WholeScenes(root * root / (d * d) + 1 / d);
}

double DeviationOfRise(std::span<const Cluster> before, std::span<const Cluster> after) {
  if (before.size() != after.size()) throw std::logic_error("pairs differ in number");
  PairSums sums;
  for (size_t i = 0; i < before.size(); ++i) sums.Add(before[i], after[i], 1);
  if (sums.t[0] == 0 || sums.t[1] == 0) return 0;
  return std::sqrt(sums.Variance() * static_cast<double>(before.size()));
}

}  // namespace pickbed
