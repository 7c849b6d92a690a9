#include "eval/roc.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "scenes/random.h"

namespace pickbed {
namespace {

// Places from 1 in ascending order; ties share the mean of theirs.
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

// What each outcome alone says: for a success the share of the failures that score below it, for a
// failure the share of the successes above it. The mean of either is the AUC.
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

// Of the mean of (a - b); b may be empty.
double VarianceOfMean(const std::vector<double>& a, const std::vector<double>& b = {}) {
  if (a.size() < 2) return 0;
  std::vector<double> d = a;
  for (size_t i = 0; i < b.size(); ++i) d[i] -= b[i];
  const double mean = Mean(d);
  double sum = 0;
  for (const double value : d) sum += (value - mean) * (value - mean);
  return sum / double(d.size() - 1) / double(d.size());
}

double TwoSidedZ(double confidence) {
  return boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
}

double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

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
  if (result.auc <= 0 || result.auc >= 1) {
    result.interval = WilsonInterval(result.auc > 0.5 ? pairs : 0, pairs, confidence);
    return result;
  }
  const double logit = std::log(result.auc / (1 - result.auc));
  const double half = TwoSidedZ(confidence) * std::sqrt(variance) / (result.auc * (1 - result.auc));
  result.interval = {Logistic(logit - half), Logistic(logit + half)};
  return result;
}

AucDifference CompareAuc(std::span<const ScoredOutcome> a, std::span<const ScoredOutcome> b,
                         double confidence) {
  const bool same = a.size() == b.size() &&
                    std::equal(a.begin(), a.end(), b.begin(),
                               [](const auto& p, const auto& q) { return p.success == q.success; });
  if (!same) throw std::logic_error("AUCs of different outcomes cannot be compared");
  const AucResult first = Auc(a);
  if (first.successes == 0 || first.failures == 0) return {};
  const Placements of_a = PlacementsOf(a), of_b = PlacementsOf(b);
  const double variance = VarianceOfMean(of_a.of_successes, of_b.of_successes) +
                          VarianceOfMean(of_a.of_failures, of_b.of_failures);
  const double difference = Mean(of_a.of_successes) - Mean(of_b.of_successes);
  const double half = TwoSidedZ(confidence) * std::sqrt(variance);
  return {difference, {difference - half, difference + half}};
}

Interval ClusterBootstrapAuc(std::span<const std::vector<ScoredOutcome>> clusters,
                             double confidence, int resamples, uint64_t seed) {
  Rng rng(seed);
  std::vector<double> aucs;
  for (int i = 0; i < resamples; ++i) {
    std::vector<ScoredOutcome> drawn;
    for (size_t k = 0; k < clusters.size(); ++k) {
      const auto& cluster = clusters[rng.Index(static_cast<int>(clusters.size()))];
      drawn.insert(drawn.end(), cluster.begin(), cluster.end());
    }
    const AucResult result = Auc(drawn, confidence);
    if (result.successes > 0 && result.failures > 0) aucs.push_back(result.auc);
  }
  if (aucs.empty()) return {};
  std::sort(aucs.begin(), aucs.end());
  const auto at = [&](double share) {
    return aucs[static_cast<size_t>(std::lround(share * double(aucs.size() - 1)))];
  };
  return {at((1 - confidence) / 2), at((1 + confidence) / 2)};
}

}  // namespace pickbed
