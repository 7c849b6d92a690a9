#pragma once

// Area under the ROC curve (AUC) of a score: the probability that a random success has a higher
// score than a random failure, with ties counted as half (Hanley and McNeil 1982). 0.5 is chance, 1
// is perfect separation.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

// Score (higher = success expected) and true outcome.
struct ScoredOutcome {
  double score = 0;
  bool success = false;
};

// AUC with its interval; 0.5 if one of the outcomes is missing.
struct AucResult {
  double auc = 0.5;
  Interval interval;  // at the requested confidence
  int successes = 0, failures = 0;
  bool is_known() const { return successes > 0 && failures > 0; }
};

// AUC with the variance of DeLong, DeLong and Clarke-Pearson (1988), computed by ranks as in Sun
// and Xu (2014). The interval is normal on the logit scale, so it stays within 0..1. With perfect
// (or perfectly wrong) separation this variance is 0. The interval is then Wilson's for
// min(successes, failures) independent pairs that are all ordered alike. {0.5, [0, 1]} without both
// outcomes.
AucResult Auc(std::span<const ScoredOutcome> outcomes, double confidence = 0.95);

// "0.812 [0.704, 0.887]", or "0.812 (too few bins)".
std::string AucText(const AucResult& auc);

// AUC of `a` minus AUC of `b` on the same outcomes in the same order, with the interval from
// DeLong's covariance. If both separate perfectly, the interval has the width that their own
// intervals allow. Throws std::logic_error if the outcomes differ.
struct AucDifference {
  double difference = 0;
  Interval interval{-1, 1};
};
// Computes the difference and its interval.
AucDifference CompareAuc(std::span<const ScoredOutcome> a, std::span<const ScoredOutcome> b,
                         double confidence = 0.95);

// Interval if outcomes of one cluster (a bin) are not independent: percentiles over `resamples`
// draws of clusters with replacement. Draws without both outcomes are ignored. If all draws
// separate perfectly (or perfectly wrongly), the interval would have zero width. Then it is
// Wilson's, with as many pairs as there are clusters with a success, or with a failure if that is
// smaller. [0, 1] if no draw has both outcomes; unknown with fewer than kMinBinsOfInterval
// clusters. Equal seeds give equal intervals.
using OutcomeClusters = std::vector<std::vector<ScoredOutcome>>;
// Computes the interval.
Interval ClusterBootstrapAuc(const OutcomeClusters& clusters, double confidence = 0.95,
                             int resamples = 1000, uint64_t seed = 0);
// Like ClusterBootstrapAuc, for AUC of `a` minus AUC of `b` with the same outcomes in the same
// clusters and order. [-1, 1] if no draw has both outcomes; unknown with fewer than
// kMinBinsOfInterval clusters. Throws std::logic_error if the numbers of clusters differ.
Interval ClusterBootstrapAucDifference(const OutcomeClusters& a, const OutcomeClusters& b,
                                       double confidence = 0.95, int resamples = 1000,
                                       uint64_t seed = 0);

}  // namespace pickbed::eval
