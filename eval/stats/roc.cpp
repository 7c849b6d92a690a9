#include "eval/stats/roc.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "scenes/base/math.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

// Ranks from 1 in ascending order; ties get the mean rank.
std::vector<double> MidRanks(const std::vector<double>& values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (size_t first = 0; first < order.size();) {
    size_t last = first;
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    for (size_t i = first; i < last; ++i) ranks[order[i]] = 0.5 * double(first + last + 1);
    first = last;
  }
  return ranks;
}

// Placement values. For a success: share of the failures with a lower score. For a failure: share
// of the successes with a higher score. The mean of either list is the AUC.
struct Placements {
  std::vector<double> of_successes, of_failures;
};

Placements PlacementsOf(std::span<const ScoredOutcome> outcomes) {
  std::vector<double> all, successes, failures;
  for (const ScoredOutcome& outcome : outcomes) {
    all.push_back(outcome.score);
    (outcome.success ? successes : failures).push_back(outcome.score);
  }
  const std::vector<double> among_all = MidRanks(all);
  const std::vector<double> among_successes = MidRanks(successes);
  const std::vector<double> among_failures = MidRanks(failures);
  Placements placements;
  for (size_t i = 0, s = 0, f = 0; i < outcomes.size(); ++i) {
    if (outcomes[i].success) {
      const double below = among_all[i] - among_successes[s++];
      placements.of_successes.push_back(below / double(failures.size()));
    } else {
      const double below = among_all[i] - among_failures[f++];
      placements.of_failures.push_back(1 - below / double(successes.size()));
    }
  }
  return placements;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// Variance of the mean of (a - b); b may be empty.
double VarianceOfMean(const std::vector<double>& a, const std::vector<double>& b = {}) {
  if (a.size() < 2) return 0;
  std::vector<double> d = a;
  for (size_t i = 0; i < b.size(); ++i) d[i] -= b[i];
  const double mean = Mean(d);
  double sum = 0;
  for (const double value : d) sum += (value - mean) * (value - mean);
  return sum / double(d.size() - 1) / double(d.size());
}

// AUC over all drawn clusters; nullopt without both outcomes.
std::optional<double> AucOf(const OutcomeClusters& clusters, const std::vector<int>& drawn) {
  std::vector<ScoredOutcome> outcomes;
  for (const int i : drawn) {
    outcomes.insert(outcomes.end(), clusters[i].begin(), clusters[i].end());
  }
  const AucResult result = Auc(outcomes);
  if (result.successes == 0 || result.failures == 0) return std::nullopt;
  return result.auc;
}

using Statistic = std::function<std::optional<double>(const std::vector<int>& drawn)>;

// Percentiles of the statistic over draws of `count` clusters with replacement; nullopt if no draw
// has a value.
std::optional<Interval> Bootstrap(int count, double confidence, int resamples, uint64_t seed,
                                  const Statistic& statistic) {
  Rng rng(seed);
  std::vector<double> values;
  for (int i = 0; i < resamples; ++i) {
    std::vector<int> drawn(count);
    for (int& cluster : drawn) cluster = rng.Index(count);
    if (const auto value = statistic(drawn)) values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<size_t>(std::lround(share * double(values.size() - 1)))];
  };
  return Interval{at((1 - confidence) / 2), at((1 + confidence) / 2)};
}

// Number of clusters with a success, or with a failure if that is smaller.
int ClustersWithEither(const OutcomeClusters& clusters) {
  const auto with = [&](bool success) {
    return std::count_if(clusters.begin(), clusters.end(), [&](const auto& cluster) {
      return std::any_of(cluster.begin(), cluster.end(),
                         [&](const ScoredOutcome& outcome) { return outcome.success == success; });
    });
  };
  return static_cast<int>(std::min(with(true), with(false)));
}

}  // namespace

AucResult Auc(std::span<const ScoredOutcome> outcomes, double confidence) {
  AucResult result;
  for (const ScoredOutcome& outcome : outcomes) {
    ++(outcome.success ? result.successes : result.failures);
  }
  if (result.successes == 0 || result.failures == 0) return result;
  const Placements placements = PlacementsOf(outcomes);
  result.auc = Mean(placements.of_successes);
  const double variance =
      VarianceOfMean(placements.of_successes) + VarianceOfMean(placements.of_failures);
  const int pairs = std::min(result.successes, result.failures);
  if (pairs < 2) {  // one sample of a class gives no spread
    result.interval = {0, 1};
    return result;
  }
  if (result.auc <= 0 || result.auc >= 1) {
    result.interval = WilsonInterval(result.auc > 0.5 ? pairs : 0, pairs, confidence);
    return result;
  }
  const double logit = std::log(result.auc / (1 - result.auc));
  const double half = TwoSidedZ(confidence) * std::sqrt(variance) / (result.auc * (1 - result.auc));
  result.interval = {Logistic(logit - half), Logistic(logit + half)};
  return result;
}

std::string AucText(const AucResult& auc) {
  if (!auc.interval.is_known()) return fmt::format("{:.3f} ({})", auc.auc, kTooFewBins);
  return fmt::format("{:.3f} [{:.3f}, {:.3f}]", auc.auc, auc.interval.low, auc.interval.high);
}

AucDifference CompareAuc(std::span<const ScoredOutcome> a, std::span<const ScoredOutcome> b,
                         double confidence) {
  const bool same = a.size() == b.size() &&
                    std::equal(a.begin(), a.end(), b.begin(),
                               [](const auto& p, const auto& q) { return p.success == q.success; });
  if (!same) throw std::logic_error("AUCs of different outcomes cannot be compared");
  const AucResult all_a = Auc(a, confidence), all_b = Auc(b, confidence);
  if (all_a.successes == 0 || all_a.failures == 0) return {};
  if (std::min(all_a.successes, all_a.failures) < 2) return {all_a.auc - all_b.auc, {-1, 1}};
  const auto extreme = [](double auc) { return auc <= 0 || auc >= 1; };
  if (extreme(all_a.auc) && extreme(all_b.auc)) {
    return {all_a.auc - all_b.auc,
            {all_a.interval.low - all_b.interval.high, all_a.interval.high - all_b.interval.low}};
  }
  const Placements of_a = PlacementsOf(a), of_b = PlacementsOf(b);
  const double variance = VarianceOfMean(of_a.of_successes, of_b.of_successes) +
                          VarianceOfMean(of_a.of_failures, of_b.of_failures);
  const double difference = Mean(of_a.of_successes) - Mean(of_b.of_successes);
  const double half = TwoSidedZ(confidence) * std::sqrt(variance);
  return {difference, {std::max(-1.0, difference - half), std::min(1.0, difference + half)}};
}

Interval ClusterBootstrapAuc(const OutcomeClusters& clusters, double confidence, int resamples,
                             uint64_t seed) {
  if (clusters.size() < kMinBinsOfInterval) return Interval::Unknown();
  const std::optional<Interval> drawn_interval =
      Bootstrap(static_cast<int>(clusters.size()), confidence, resamples, seed,
                [&](const std::vector<int>& drawn) { return AucOf(clusters, drawn); });
  if (!drawn_interval) return {0, 1};
  const bool no_spread = drawn_interval->low == drawn_interval->high &&
                         (drawn_interval->low <= 0 || drawn_interval->low >= 1);
  if (!no_spread) return *drawn_interval;
  const int pairs = ClustersWithEither(clusters);
  return WilsonInterval(drawn_interval->low > 0.5 ? pairs : 0, pairs, confidence);
}

Interval ClusterBootstrapAucDifference(const OutcomeClusters& a, const OutcomeClusters& b,
                                       double confidence, int resamples, uint64_t seed) {
  if (a.size() != b.size()) throw std::logic_error("AUCs of different outcomes, see CompareAuc");
  if (a.size() < kMinBinsOfInterval) return Interval::Unknown();
  return Bootstrap(static_cast<int>(a.size()), confidence, resamples, seed,
                   [&](const std::vector<int>& drawn) -> std::optional<double> {
                     const auto of_a = AucOf(a, drawn), of_b = AucOf(b, drawn);
                     if (!of_a || !of_b) return std::nullopt;
                     return *of_a - *of_b;
                   })
      .value_or(Interval{-1, 1});
}

}  // namespace pickbed::eval
