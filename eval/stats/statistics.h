#pragma once

// Rates and medians with confidence intervals; the distributions are from Boost.Math.
//
// Scenes are the independent units, because picks of one bin and instances of one image are not
// independent. So an interval is computed from the contribution of each scene (a Cluster),
// regardless of the number of samples in it.

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Interval {
  double low = 0;
  double high = 1;
};

// Wilson score interval (Wilson 1927) of successes / attempts; [0, 1] without attempts. Only valid
// for independent attempts.
Interval WilsonInterval(int successes, int attempts, double confidence = 0.95);

// Number of standard deviations on each side of a normal distribution that contain `confidence`.
double TwoSidedZ(double confidence);
// Like TwoSidedZ, for Student's t. `degrees` of freedom may be fractional; infinity gives the
// normal.
double TwoSidedT(double confidence, double degrees);

// Contribution of one independent unit (a scene) to a rate: `hits` of `samples`.
struct Cluster {
  int hits = 0;
  int samples = 0;
};
// Sum of hits and of samples.
Cluster SumOf(std::span<const Cluster> clusters);
// sum(hits) / sum(samples); 0 without samples.
double RateOf(std::span<const Cluster> clusters);

// Interval of sum(hits) / sum(samples) if the samples of one cluster are not independent and
// clusters differ in size. It has Wilson's form with an effective number of samples p q / v (Korn
// and Graubard 1998; Dean and Pagano 2015), where v is the cluster jackknife variance of the ratio.
// Student's t has Satterthwaite's degrees of freedom, from the fourth moment of the residuals
// (statistics.cpp). 95 % intervals cover 93 to 97 % for at least 40 clusters and rates of 0.1 to
// 0.9 (tests/figures/interval_figures.cpp). Percentile bootstraps do not reach this. With one
// sample per cluster it equals Wilson's interval. If all samples agree, the correlation in a
// cluster is unknown and each cluster counts as one sample. [0, 1] without samples. Clusters
// without samples have no effect.
Interval ClusterInterval(std::span<const Cluster> clusters, double confidence = 0.95);

// Interval of the increase of the rate from `before` to `after`, which hold the same units in the
// same order. Two pseudo-scenes with one sample are added, one hit only before and one only after
// (Bonett and Price 2012). The variance over units is linearized, with Student's t. If no unit
// differs, each counts as one sample, so that the interval has a width. [-1, 1] if either has no
// samples. Throws std::logic_error if the numbers of units differ.
Interval PairedInterval(std::span<const Cluster> before, std::span<const Cluster> after,
                        double confidence = 0.95);

// Values by unit, for example the pose errors of each scene.
using ValueClusters = std::vector<std::vector<double>>;

// Median of all values, the lower one of two; NaN without values.
double MedianOf(const ValueClusters& clusters);
// Interval of the median (Woodruff 1952): the values at the ends of the ClusterInterval of the
// share at or below the median. If no cluster has more than one value, it uses order statistics of
// independent values with a coverage of at least `confidence` (David and Nagaraja 2003, sec. 7.1);
// 95 % needs six values. Values may be infinite. [-inf, inf] if nothing is known.
Interval MedianInterval(const ValueClusters& clusters, double confidence = 0.95);

// Minimum number of bins for reliable intervals. With few bins, intervals are wide. Bootstrap
// intervals of an AUC are then too narrow, because resamples of few bins vary less than new bins.
inline constexpr int kFewBins = 20;

// Warning sentence if there are fewer than kFewBins bins; else empty.
std::string FewBinsText(int bins);

// Rate with its 95 % interval, as shown in reports.
struct ReportRate {
  int hits = 0, samples = 0;
  Interval ci95;
  double rate() const { return samples > 0 ? static_cast<double>(hits) / samples : 0; }
};

// Rate over clusters, with its ClusterInterval.
ReportRate ClusterRate(std::span<const Cluster> clusters);

// Returns a CSV cell, in quotes if the text holds a comma, a quote or a line break.
std::string CsvCell(const std::string& text);

// The formatters of shares and rates. Except WholePercentText(), all have one decimal.
//
// "12.5", for tables with the unit in the header.
std::string PercentNumber(double share);
// "12.5 %".
std::string PercentText(double share);
// Same for hits / samples, or "-" without samples.
std::string PercentText(int hits, int samples);
// "12 %", for progress and for settings.
std::string WholePercentText(double share);
// "[8.1, 18.4]".
std::string IntervalText(const Interval& interval);
// "12.5 % [8.1, 18.4]", or "-" without samples.
std::string RateText(const ReportRate& rate);
// Same for a rate whose samples are not known.
std::string RateText(double rate, const Interval& ci95);
// "+12.5": difference of two shares in percentage points; "-" if it is not finite.
std::string PointsText(double difference);
// "+12.5 [+8.1, +18.4]".
std::string PointsText(double difference, const Interval& interval);

}  // namespace pickbed::eval
