#include "eval/stats/paired_tests.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

constexpr double kMaxScenes = 1e7;

// Differences that are equal except for rounding count as equal. Otherwise the p value would be too
// small.
constexpr double kRounding = 1e-9;

double OneSidedZ(double share) { return boost::math::quantile(boost::math::normal(), share); }

std::optional<int> WholeScenes(double scenes) {
  if (!(scenes <= kMaxScenes)) return std::nullopt;
  return std::max(2, static_cast<int>(std::ceil(scenes)));
}

// Sums over scenes of h (hits) and t (trials) of two configurations, and of their products. The
// rates, their difference and its linearized variance follow directly, also after labels change.
struct PairSums {
  double h[2] = {0, 0}, t[2] = {0, 0};
  double hh[2] = {0, 0}, ht[2] = {0, 0}, tt[2] = {0, 0};
  double h0h1 = 0, h0t1 = 0, t0h1 = 0, t0t1 = 0;

  void Add(const Cluster& zero, const Cluster& one) {
    const Cluster* of[2] = {&zero, &one};
    for (int k = 0; k < 2; ++k) {
      const double hits = of[k]->hits, samples = of[k]->samples;
      h[k] += hits;
      t[k] += samples;
      hh[k] += hits * hits;
      ht[k] += hits * samples;
      tt[k] += samples * samples;
    }
    h0h1 += static_cast<double>(zero.hits) * one.hits;
    h0t1 += static_cast<double>(zero.hits) * one.samples;
    t0h1 += static_cast<double>(zero.samples) * one.hits;
    t0t1 += static_cast<double>(zero.samples) * one.samples;
  }

  void Add(const PairSums& other, double sign) {
    for (int k = 0; k < 2; ++k) {
      h[k] += sign * other.h[k];
      t[k] += sign * other.t[k];
      hh[k] += sign * other.hh[k];
      ht[k] += sign * other.ht[k];
      tt[k] += sign * other.tt[k];
    }
    h0h1 += sign * other.h0h1;
    h0t1 += sign * other.h0t1;
    t0h1 += sign * other.t0h1;
    t0t1 += sign * other.t0t1;
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

  // difference| divided by its standard error.
  double Size() const {
    if (t[0] == 0 || t[1] == 0) return 0;
    const double rise = std::abs(Rise());
    if (rise < kRounding) return 0;
    const double variance = Variance();
    return variance > kRounding * rise * rise ? rise / std::sqrt(variance) : kInfinity;
  }
};

// Value with its scene and configuration.
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

// Median of the values with label 1 minus median of the values with label 0. Each value is weighted
// by the count of its scene. NaN if a label has no values, or if both medians are infinite.
template <typename Label>
double MedianRise(const std::vector<PooledValue>& pool, const std::vector<int>& counts,
                  const Label& label) {
  long totals[2] = {0, 0};
  for (const PooledValue& value : pool) totals[label(value)] += counts[value.scene];
  if (totals[0] == 0 || totals[1] == 0) return std::numeric_limits<double>::quiet_NaN();
  long passed[2] = {0, 0};
  double medians[2] = {0, 0};
  bool known[2] = {false, false};
  for (const PooledValue& value : pool) {
    const int k = label(value);
    passed[k] += counts[value.scene];
    if (known[k] || 2 * passed[k] < totals[k]) continue;
    medians[k] = value.value;
    known[k] = true;
    if (known[1 - k]) break;
  }
  return medians[1] - medians[0];
}

// Reduces the number of draws so that all draws together use at most kMaxValues; at least 200.
int FewerDraws(int draws, size_t values) {
  constexpr double kMaxValues = 1e8;
  constexpr int kFewestDraws = 200;
  const double affordable = kMaxValues / std::max<double>(1, static_cast<double>(values));
  return affordable >= draws ? draws : std::max(kFewestDraws, static_cast<int>(affordable));
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
  const double ratio = scenes.before_only > 0
                           ? static_cast<double>(scenes.after_only) / scenes.before_only
                           : kInfinity;
  return OddsRatio{ratio, {odds(low), odds(high)}};
}

double SignFlipTest(int scenes, const FlipStatistic& statistic, int flips, uint64_t seed) {
  std::vector<bool> flipped(scenes, false);
  const double found = statistic(flipped);
  // Without spread the statistic is infinite, and infinity minus infinity is no number.
  const double minimum = std::isfinite(found) ? found - kRounding * std::abs(found) : found;
  if (scenes < 31 && (1L << scenes) <= flips) {
    const long all = 1L << scenes;
    long as_large = 0;
    for (long pattern = 0; pattern < all; ++pattern) {
      for (int i = 0; i < scenes; ++i) flipped[i] = pattern >> i & 1;
      as_large += statistic(flipped) >= minimum;
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
    as_large += statistic(flipped) >= minimum;
  }
  return static_cast<double>(as_large) / (flips + 1.0);
}

double PairedRateTest(std::span<const Cluster> before, std::span<const Cluster> after, int flips,
                      uint64_t seed) {
  if (before.size() != after.size()) throw std::logic_error("pairs differ in number");
  PairSums found;
  std::vector<PairSums> changes;  // change of the sums if the labels of a scene change
  for (size_t i = 0; i < before.size(); ++i) {
    found.Add(before[i], after[i]);
    // Scenes with equal results do not depend on their labels.
    if (before[i].hits == after[i].hits && before[i].samples == after[i].samples) continue;
    PairSums as_is, changed;
    as_is.Add(before[i], after[i]);
    changed.Add(after[i], before[i]);
    changed.Add(as_is, -1);
    changes.push_back(changed);
  }
  const auto size = [&](const std::vector<bool>& flipped) {
    PairSums sums = found;
    for (size_t i = 0; i < changes.size(); ++i) {
      if (flipped[i]) sums.Add(changes[i], 1);
    }
    return sums.Size();
  };
  return SignFlipTest(static_cast<int>(changes.size()), size, flips, seed);
}

double PairedMedianTest(const ValueClusters& before, const ValueClusters& after, int flips,
                        uint64_t seed) {
  const std::vector<PooledValue> pool = Pooled(before, after);
  const std::vector<int> once(before.size(), 1);
  const auto size = [&](const std::vector<bool>& flipped) {
    const auto label = [&](const PooledValue& value) {
      return value.configuration ^ static_cast<int>(flipped[value.scene]);
    };
    const double difference = MedianRise(pool, once, label);
    // Two infinite medians count as equal. Labels that leave one side without values give 0.
    return std::isnan(difference) ? 0 : std::abs(difference);
  };
  return SignFlipTest(static_cast<int>(before.size()), size, FewerDraws(flips, pool.size()), seed);
}

Interval PairedMedianInterval(const ValueClusters& before, const ValueClusters& after,
                              double confidence, int resamples, uint64_t seed) {
  const std::vector<PooledValue> pool = Pooled(before, after);
  const auto label = [](const PooledValue& value) { return value.configuration; };
  const int scenes = static_cast<int>(before.size());
  Rng rng(seed);
  std::vector<double> differences;
  const int draws = FewerDraws(resamples, pool.size());
  for (int k = 0; k < draws; ++k) {
    std::vector<int> counts(scenes, 0);
    for (int i = 0; i < scenes; ++i) ++counts[rng.Index(scenes)];
    const double difference = MedianRise(pool, counts, label);
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
  for (size_t i = 0; i < before.size(); ++i) sums.Add(before[i], after[i]);
  if (sums.t[0] == 0 || sums.t[1] == 0) return 0;
  return std::sqrt(sums.Variance() * static_cast<double>(before.size()));
}

}  // namespace pickbed::eval
