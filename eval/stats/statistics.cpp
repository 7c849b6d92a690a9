#include "eval/stats/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace pickbed::eval {
namespace {

// Fourth moments of few units are too low on average, because large residuals are rare. With this
// factor on Satterthwaite's degrees of freedom, 95 % intervals of 40 units cover at least 93 % if
// few units hold most of the hits (tests/figures/interval_figures.cpp).
constexpr double kTrustInMoments = 0.7;

double Square(double x) { return x * x; }

double Clamped(double x) { return std::clamp(x, 0.0, 1.0); }

// Wilson interval of a rate p with the precision of `samples` independent draws.
Interval WilsonForm(double p, double samples, double z) {
  const double center = (p + z * z / (2 * samples)) / (1 + z * z / samples);
  const double half = z / (1 + z * z / samples) *
                      std::sqrt(p * (1 - p) / samples + z * z / (4 * samples * samples));
  // The ends are exact at the extremes; rounding would give 0.9999999999999999.
  return {p <= 0 ? 0.0 : Clamped(center - half), p >= 1 ? 1.0 : Clamped(center + half)};
}

// Contribution of a unit to a ratio sum(total) / sum(weight).
struct Share {
  double total = 0, weight = 0;
};

struct Spread {
  double variance = 0;  // of an estimate
  double degrees = 0;   // degrees of freedom of the variance
};

// Jackknife variance from the change when each unit is left out, with Satterthwaite's degrees of
// freedom. The variance of a sum of squares is about the spread of its terms; twice its square
// divided by that variance gives the degrees (Satterthwaite 1946).
Spread SpreadOf(const std::vector<double>& left_out, double trust) {
  double squares = 0, fourths = 0;
  for (const double change : left_out) {
    squares += Square(change);
    fourths += Square(Square(change));
  }
  const double units = static_cast<double>(left_out.size());
  const double spread_of_squares = fourths - Square(squares) / units;
  const double degrees = trust * 2 * Square(squares) / spread_of_squares;
  return {squares, spread_of_squares > 0 ? std::clamp(degrees, 1.0, units - 1) : units - 1};
}

// Ratio of sums over units, with its spread.
struct RatioSpread {
  int units = 0;  // with a weight
  double ratio = 0;
  double weight = 0;  // of all units
  Spread spread;
};

// Leaving out a unit changes the ratio by its residual (total - ratio weight) divided by the weight
// of the other units (Tukey's jackknife; CR3 of Bell and McCaffrey 2002).
RatioSpread SpreadOf(const std::vector<Share>& units) {
  RatioSpread result;
  double total = 0;
  for (const Share& unit : units) {
    result.units += unit.weight > 0;
    total += unit.total;
    result.weight += unit.weight;
  }
  if (result.units == 0) return result;
  result.ratio = total / result.weight;
  if (result.units < 2) return result;
  std::vector<double> left_out;
  for (const Share& unit : units) {
    if (unit.weight <= 0) continue;
    left_out.push_back((unit.total - result.ratio * unit.weight) / (result.weight - unit.weight));
  }
  result.spread = SpreadOf(left_out, kTrustInMoments);
  return result;
}

// True if rates correlate with cluster sizes, for example if a trial ends when picks fail. Compares
// the sum of residual times size with its standard error.
bool RatesGoWithSizes(std::span<const Cluster> clusters, const RatioSpread& spread) {
  const double mean = spread.weight / spread.units;
  double sum = 0, squares = 0;
  for (const Cluster& cluster : clusters) {
    if (cluster.samples == 0) continue;
    const double term = (cluster.samples - mean) * (cluster.hits - spread.ratio * cluster.samples);
    sum += term;
    squares += Square(term);
  }
  return Square(sum) > squares;
}

// Minimum degrees of freedom, from the sizes of the clusters. The design effect is between 1
// (samples of a cluster are independent) and sum(t^2) / sum(t) (all equal). If that range is
// narrow, the variance is known regardless of the moments. The logarithm is taken as uniform in the
// range, with variance length^2 / 12. The degrees are 2 divided by the variance of the logarithm.
// This does not hold if rates correlate with sizes, which widens the range.
double MinDegrees(std::span<const Cluster> clusters, const RatioSpread& spread) {
  if (RatesGoWithSizes(clusters, spread)) return 1;
  double squares = 0;
  for (const Cluster& cluster : clusters) squares += Square(cluster.samples);
  const double length = std::log(squares / spread.weight);
  return length > 0 ? 24 / Square(length) : kInfinity;
}

int WithSamples(std::span<const Cluster> clusters) {
  return static_cast<int>(
      std::count_if(clusters.begin(), clusters.end(),
                    [](const Cluster& cluster) { return cluster.samples > 0; }));
}

bool TryOnce(std::span<const Cluster> clusters) {
  return std::all_of(clusters.begin(), clusters.end(),
                     [](const Cluster& cluster) { return cluster.samples <= 1; });
}

std::vector<Share> SharesOf(std::span<const Cluster> clusters) {
  std::vector<Share> shares;
  shares.reserve(clusters.size());
  for (const Cluster& cluster : clusters) {
    shares.push_back({static_cast<double>(cluster.hits), static_cast<double>(cluster.samples)});
  }
  return shares;
}

std::vector<double> Sorted(const ValueClusters& clusters) {
  std::vector<double> values;
  for (const auto& cluster : clusters) values.insert(values.end(), cluster.begin(), cluster.end());
  std::sort(values.begin(), values.end());
  return values;
}

double AtShare(const std::vector<double>& sorted, double share) {
  const double place = std::ceil(share * static_cast<double>(sorted.size())) - 1;
  const double last = static_cast<double>(sorted.size()) - 1;
  return sorted[static_cast<size_t>(std::clamp(place, 0.0, last))];
}

// Sign-test interval of the median of independent values: a value is below the median with
// probability 1/2. With fewer than six values, even the full range has a coverage below 95 %.
Interval OrderStatistics(const std::vector<double>& sorted, double confidence) {
  const boost::math::binomial below(static_cast<double>(sorted.size()), 0.5);
  size_t rank = 0;  // at most this many values below it have a too small probability
  while (2 * cdf(below, static_cast<double>(rank)) <= 1 - confidence) ++rank;
  if (rank == 0) return Interval::Unknown();
  return {sorted[rank - 1], sorted[sorted.size() - rank]};
}

// Interval of a rate over clusters with more than one sample whose samples do not all agree.
Interval MixedInterval(std::span<const Cluster> clusters, double confidence) {
  const RatioSpread spread = SpreadOf(SharesOf(clusters));
  const double p = spread.ratio;
  // Equal rates in all clusters do not make the rate certain.
  const double variance =
      spread.spread.variance > 0 ? spread.spread.variance : p * (1 - p) / spread.weight;
  const double degrees = std::max(spread.spread.degrees, MinDegrees(clusters, spread));
  return WilsonForm(p, p * (1 - p) / variance, TwoSidedT(confidence, degrees));
}

// Width of the interval if all samples agree. Data with one other sample bound it.
double WidthIfAllAgree(std::span<const Cluster> clusters, bool hits, double confidence) {
  const Interval of_clusters =
      WilsonForm(hits ? 1 : 0, WithSamples(clusters), TwoSidedZ(confidence));
  double width = of_clusters.high - of_clusters.low;
  std::vector<Cluster> changed(clusters.begin(), clusters.end());
  std::set<int> sizes;
  for (Cluster& cluster : changed) {
    if (cluster.samples == 0 || !sizes.insert(cluster.samples).second) continue;
    const Cluster before = cluster;
    cluster.hits += hits ? -1 : 1;
    const Interval interval = MixedInterval(changed, confidence);
    width = std::min(width, interval.high - interval.low);
    cluster = before;
  }
  return width;
}

// The interval, or "(too few bins)".
std::string Bracketed(const Interval& interval) {
  return interval.is_known() ? IntervalText(interval) : fmt::format("({})", kTooFewBins);
}

}  // namespace

double TwoSidedZ(double confidence) {
  return boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
}

double TwoSidedT(double confidence, double degrees) {
  // Above this, t and normal agree to five digits, and the series in Boost is slow.
  constexpr double kNormalFrom = 1e5;
  if (degrees > kNormalFrom) return TwoSidedZ(confidence);
  return boost::math::quantile(boost::math::students_t(degrees), 0.5 + 0.5 * confidence);
}

Cluster SumOf(std::span<const Cluster> clusters) {
  Cluster sum;
  for (const Cluster& cluster : clusters) {
    sum.hits += cluster.hits;
    sum.samples += cluster.samples;
  }
  return sum;
}

double RateOf(std::span<const Cluster> clusters) {
  const Cluster sum = SumOf(clusters);
  return sum.samples > 0 ? static_cast<double>(sum.hits) / sum.samples : 0;
}

Interval WilsonInterval(int successes, int attempts, double confidence) {
  if (attempts <= 0) return {0, 1};
  return WilsonForm(static_cast<double>(successes) / attempts, attempts, TwoSidedZ(confidence));
}

Interval ClusterInterval(std::span<const Cluster> clusters, double confidence) {
  const int units = WithSamples(clusters);
  if (units < kMinBinsOfInterval) return Interval::Unknown();
  const Cluster sum = SumOf(clusters);
  if (TryOnce(clusters)) return WilsonInterval(sum.hits, sum.samples, confidence);
  if (sum.hits == 0) return {0, WidthIfAllAgree(clusters, false, confidence)};
  if (sum.hits == sum.samples) return {1 - WidthIfAllAgree(clusters, true, confidence), 1};
  return MixedInterval(clusters, confidence);
}

Interval PairedInterval(std::span<const Cluster> before, std::span<const Cluster> after,
                        double confidence) {
  if (before.size() != after.size()) throw std::logic_error("pairs differ in number");
  if (SumOf(before).samples == 0 || SumOf(after).samples == 0) return Interval::Unknown();
  std::vector<Cluster> a, b;
  bool differ = false;
  for (size_t i = 0; i < before.size(); ++i) {
    if (before[i].samples + after[i].samples == 0) continue;
    differ |= before[i].hits * after[i].samples != after[i].hits * before[i].samples;
    a.push_back(before[i]);
    b.push_back(after[i]);
  }
  if (a.size() < kMinBinsOfInterval) return Interval::Unknown();
  if (!differ) {
    for (size_t i = 0; i < a.size(); ++i) a[i] = b[i] = {1, 1};
  }
  a.insert(a.end(), {{1, 1}, {0, 1}});
  b.insert(b.end(), {{0, 1}, {1, 1}});
  const double rate_a = RateOf(a), rate_b = RateOf(b);
  const Cluster sum_a = SumOf(a), sum_b = SumOf(b);
  std::vector<double> left_out;
  for (size_t i = 0; i < a.size(); ++i) {
    left_out.push_back((b[i].hits - rate_b * b[i].samples) / (sum_b.samples - b[i].samples) -
                       (a[i].hits - rate_a * a[i].samples) / (sum_a.samples - a[i].samples));
  }
  const Spread spread = SpreadOf(left_out, 1);
  const bool single = TryOnce(a) && TryOnce(b);
  const double half = std::sqrt(spread.variance) *
                      (single ? TwoSidedZ(confidence) : TwoSidedT(confidence, spread.degrees));
  const double rise = rate_b - rate_a;
  return {std::max(-1.0, rise - half), std::min(1.0, rise + half)};
}

double MedianOf(const ValueClusters& clusters) {
  const std::vector<double> values = Sorted(clusters);
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : AtShare(values, 0.5);
}

Interval MedianInterval(const ValueClusters& clusters, double confidence) {
  const std::vector<double> values = Sorted(clusters);
  if (values.empty()) return Interval::Unknown();
  const bool independent = std::all_of(clusters.begin(), clusters.end(),
                                       [](const auto& cluster) { return cluster.size() <= 1; });
  if (independent) return OrderStatistics(values, confidence);
  const double median = AtShare(values, 0.5);
  std::vector<Cluster> below;
  for (const auto& cluster : clusters) {
    const auto hits = std::count_if(cluster.begin(), cluster.end(),
                                    [&](double value) { return value <= median; });
    below.push_back({static_cast<int>(hits), static_cast<int>(cluster.size())});
  }
  const Interval shares = ClusterInterval(below, confidence);
  if (!shares.is_known()) return shares;
  return {AtShare(values, shares.low), AtShare(values, shares.high)};
}

void SayTooFewBins(std::string& caption) {
  if (!caption.empty()) caption += " ";
  caption += fmt::format("A point without an interval has {} for an interval.", kTooFewBins);
}

std::string FewBinsText(int bins) {
  if (bins >= kFewBins) return "";
  if (bins < kMinBinsOfInterval) {
    return fmt::format("{} {} too few for an interval, which needs {}; use {} or more.", bins,
                       bins == 1 ? "bin is" : "bins are", kMinBinsOfInterval, kFewBins);
  }
  return fmt::format("{} {} few: the intervals are wide and approximate; use {} or more.", bins,
                     bins == 1 ? "bin is" : "bins are", kFewBins);
}

ReportRate ClusterRate(std::span<const Cluster> clusters) {
  const Cluster sum = SumOf(clusters);
  return {sum.hits, sum.samples, ClusterInterval(clusters)};
}

std::string IntervalCells(const Interval& interval, std::optional<int> decimals) {
  if (!interval.is_known()) return ",";
  if (!decimals) return fmt::format("{},{}", interval.low, interval.high);
  return fmt::format("{:.{}f},{:.{}f}", interval.low, *decimals, interval.high, *decimals);
}

std::string CsvCell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string PercentNumber(double share) { return fmt::format("{:.1f}", 100 * share); }

std::string PercentText(double share) { return PercentNumber(share) + " %"; }

// Multiplies first, so that ties such as 23 of 80 = 28.75 % are exact and round to even.
std::string PercentText(int hits, int samples) {
  return samples == 0 ? "-" : fmt::format("{:.1f} %", 100.0 * hits / samples);
}

std::string WholePercentText(double share) { return fmt::format("{:.0f} %", 100 * share); }

std::string IntervalText(const Interval& interval) {
  if (!interval.is_known()) return kTooFewBins;
  return fmt::format("[{}, {}]", PercentNumber(interval.low), PercentNumber(interval.high));
}

std::string RateText(const ReportRate& rate) {
  if (rate.samples == 0) return "-";
  return fmt::format("{} {}", PercentText(rate.hits, rate.samples), Bracketed(rate.ci95));
}

std::string ShortRateText(const ReportRate& rate) {
  return rate.ci95.is_known() ? RateText(rate) : PercentText(rate.hits, rate.samples);
}
std::string RateText(double rate, const Interval& ci95) {
  return fmt::format("{} {}", PercentText(rate), Bracketed(ci95));
}

std::string PointsText(double difference) {
  return std::isfinite(difference) ? fmt::format("{:+.1f}", 100 * difference) : "-";
}

std::string PointsText(double difference, const Interval& interval) {
  if (!interval.is_known()) return fmt::format("{} ({})", PointsText(difference), kTooFewBins);
  return fmt::format("{} [{}, {}]", PointsText(difference), PointsText(interval.low),
                     PointsText(interval.high));
}

}  // namespace pickbed::eval
