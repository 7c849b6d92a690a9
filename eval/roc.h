#pragma once

// How well a score tells successes from failures: the area under the ROC curve, which is the chance
// that a success drawn at random has the greater score of a success and a failure, ties counted
// half (Hanley and McNeil 1982). 0.5 is guessing, 1 tells all.

#include <cstdint>
#include <span>
#include <vector>

#include "eval/statistics.h"

namespace pickbed {

// A score, larger for what is thought to succeed, and what happened.
struct ScoredOutcome {
  double score = 0;
  bool success = false;
};

struct AucResult {
  double auc = 0.5;
  Interval interval;  // of confidence
  int successes = 0, failures = 0;
  bool is_known() const { return successes > 0 && failures > 0; }
};

// The variance of DeLong, DeLong and Clarke-Pearson (1988), by ranks as Sun and Xu (2014) do; the
// interval is normal on the logit, so that it stays within 0..1. Where the scores tell all (or
// nothing) that variance is 0: the interval is then Wilson's of min(successes, failures) pairs that
// share no outcome, all of them told. {0.5, [0, 1]} without successes or without failures.
AucResult Auc(std::span<const ScoredOutcome> outcomes, double confidence = 0.95);

// AUC of `a` less that of `b` on the same outcomes in the same order, with the interval of DeLong's
// covariance; where both tell all, it is as wide as their own intervals allow. Throws
// std::logic_error when the outcomes differ.
struct AucDifference {
  double difference = 0;
  Interval interval{-1, 1};
};
AucDifference CompareAuc(std::span<const ScoredOutcome> a, std::span<const ScoredOutcome> b,
                         double confidence = 0.95);

// Intervals when outcomes of one cluster (a bin) are not independent: percentiles over `resamples`
// draws of as many clusters with replacement; draws without both outcomes are left out. Where all
// draws tell all (or nothing) that would have no width: the interval is then Wilson's of as many
// pairs as there are clusters with a success or, if fewer, with a failure. [0, 1] and [-1, 1] where
// no draw has both outcomes. The same seed gives the same interval.
using OutcomeClusters = std::vector<std::vector<ScoredOutcome>>;
Interval ClusterBootstrapAuc(const OutcomeClusters& clusters, double confidence = 0.95,
                             int resamples = 1000, uint64_t seed = 0);
// Of AUC of `a` less that of `b`, the same outcomes in the same clusters and order.
Interval ClusterBootstrapAucDifference(const OutcomeClusters& a, const OutcomeClusters& b,
                                       double confidence = 0.95, int resamples = 1000,
                                       uint64_t seed = 0);

}  // namespace pickbed
