#pragma once

// Rates and medians with confidence intervals; the distributions are from Boost.Math.
//
// Scenes are the independent units, because picks of one bin and instances of one image are not
// independent. So an interval is computed from the contribution of each scene (a Cluster),
// regardless of the number of samples in it.

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Interval {
  double low = 0;
  double high = 1;

  // Returns an interval with infinite ends: nothing is known.
  static Interval Unknown() { return {-kInfinity, kInfinity}; }
  // False if nothing is known. A median with infinite errors may have one infinite end.
  bool is_known() const { return low > -kInfinity || high < kInfinity; }
};

// Minimum number of bins (independent units) for an interval of several outcomes per bin. With
// fewer, an interval covers the truth but is too wide to say anything. In simulated runs with 8 to
// 14 picks per bin, correlations of 0 to 0.3 and rates of 0.5 to 0.98, the mean widths of 95 %
// intervals of 2, 3, 4, 5 and 8 bins are 0.78, 0.52, 0.41, 0.35 and 0.26 (the command
// `interval_figures few 4000` measures this). The median of six values also needs more than five.
inline constexpr int kMinBinsOfInterval = 5;
// Text in place of an unknown interval, on the console and in tables.
inline constexpr char kTooFewBins[] = "too few bins";

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
// cluster is unknown. The interval then is the narrower of two: with each cluster counted as one
// sample, and with one sample changed, moved to the end of the range. So a further success never
// widens the interval or lowers it. Unknown with fewer than kMinBinsOfInterval clusters with
// samples. Clusters without samples have no effect.
Interval ClusterInterval(std::span<const Cluster> clusters, double confidence = 0.95);

// Interval of the increase of the rate from `before` to `after`, which hold the same units in the
// same order. Two pseudo-scenes with one sample are added, one hit only before and one only after
// (Bonett and Price 2012). The variance over units is linearized, with Student's t. If no unit
// differs, each counts as one sample, so that the interval has a width. Unknown if fewer than
// kMinBinsOfInterval units have samples, or if either has no samples. Throws std::logic_error if
// the numbers of units differ.
Interval PairedInterval(std::span<const Cluster> before, std::span<const Cluster> after,
                        double confidence = 0.95);

// Values by unit, for example the pose errors of each scene.
using ValueClusters = std::vector<std::vector<double>>;

// Median of all values, the lower one of two; NaN without values.
double MedianOf(const ValueClusters& clusters);
// Interval of the median (Woodruff 1952): the values at the ends of the ClusterInterval of the
// share at or below the median. If no cluster has more than one value, it uses order statistics of
// independent values with a coverage of at least `confidence` (David and Nagaraja 2003, sec. 7.1);
// 95 % needs six values. Values may be infinite. Unknown if fewer than kMinBinsOfInterval clusters
// have values.
Interval MedianInterval(const ValueClusters& clusters, double confidence = 0.95);

// Minimum number of bins for reliable intervals. With few bins, intervals are wide. Bootstrap
// intervals of an AUC are then too narrow, because resamples of few bins vary less than new bins.
inline constexpr int kFewBins = 20;

// Adds a sentence to the caption of a chart in which an interval is unknown.
void SayTooFewBins(std::string& caption);

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

// "0.081,0.184": two CSV cells, empty if the interval is unknown. With `decimals`, or all digits.
std::string IntervalCells(const Interval& interval, std::optional<int> decimals = std::nullopt);

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
// "[8.1, 18.4]", or kTooFewBins if it is unknown.
std::string IntervalText(const Interval& interval);
// "12.5 % [8.1, 18.4]", "12.5 % (too few bins)", or "-" without samples.
std::string RateText(const ReportRate& rate);
// Same for a rate whose samples are not known.
std::string RateText(double rate, const Interval& ci95);
// Same for tables that say only once that there are too few bins: "12.5 %" if the interval is
// unknown.
std::string ShortRateText(const ReportRate& rate);
// "+12.5": difference of two shares in percentage points; "-" if it is not finite.
std::string PointsText(double difference);
// "+12.5 [+8.1, +18.4]", or "+12.5 (too few bins)".
std::string PointsText(double difference, const Interval& interval);

}  // namespace pickbed::eval
