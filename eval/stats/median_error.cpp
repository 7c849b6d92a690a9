#include "eval/stats/median_error.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace pickbed::eval {
namespace {

// The range of five independent values contains the median with a probability of only 94 %.
constexpr size_t kFewestValues = 6;

std::string Number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

std::string Cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace

ErrorMedian ErrorMedian::Times(double factor) const {
  return {factor * value, {factor * ci95.low, factor * ci95.high}};
}

ErrorMedian MedianWithin(const ValueClusters& by_scene) {
  size_t values = 0;
  for (const std::vector<double>& scene : by_scene) values += scene.size();
  const double median = MedianOf(by_scene);
  if (values < kFewestValues) return {median, Interval::Unknown()};
  return {median, MedianInterval(by_scene)};
}

std::string MedianText(const ErrorMedian& median, int digits) {
  if (std::isnan(median.value)) return "-";
  if (!median.ci95.is_known()) {
    return fmt::format("{} ({})", Number(median.value, digits), kTooFewBins);
  }
  return fmt::format("{} [{}, {}]", Number(median.value, digits), Number(median.ci95.low, digits),
                     Number(median.ci95.high, digits));
}

std::string MedianCells(const ErrorMedian& median) {
  return fmt::format("{},{},{}", Cell(median.value), Cell(median.ci95.low), Cell(median.ci95.high));
}

}  // namespace pickbed::eval
