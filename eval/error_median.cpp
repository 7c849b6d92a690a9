#include "eval/error_median.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/paired_tests.h"

namespace pickbed {
namespace {

constexpr double kLevel = 0.05;

// 2 / 2^n is below 5 % from here on.
constexpr size_t kFewestValues = 6;
// Of one alone nothing tells how scenes differ.
constexpr size_t kFewestScenes = 2;

// Of independent values: what the sign test does not reject as median. A value lies on one side of
// it or the other as a fair coin falls, which is McNemar's test.
Interval OrderStatistics(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto count = static_cast<int>(values.size());
  int rank = 0;  // so many values below it and fewer are too few
  while (McNemarExact({rank, count - rank}) <= kLevel) ++rank;
  return {values[rank - 1], values[count - rank]};
}

std::string Number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

std::string Cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace

ErrorMedian ErrorMedian::Times(double factor) const {
  return {factor * value, {factor * ci95.low, factor * ci95.high}};
}

ErrorMedian MedianWithin(const ValueClusters& by_scene) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> values;
  size_t scenes = 0;
  for (const std::vector<double>& scene : by_scene) {
    values.insert(values.end(), scene.begin(), scene.end());
    scenes += !scene.empty();
  }
  const double median = MedianOf(by_scene);
  if (values.size() < kFewestValues || scenes < kFewestScenes) {
    return {median, {-kInfinity, kInfinity}};
  }
  if (scenes == values.size()) return {median, OrderStatistics(std::move(values))};
  return {median, MedianInterval(by_scene)};
}

std::string MedianText(const ErrorMedian& median, int digits) {
  if (std::isnan(median.value)) return "-";
  return fmt::format("{} [{}, {}]", Number(median.value, digits), Number(median.ci95.low, digits),
                     Number(median.ci95.high, digits));
}

std::string MedianCells(const ErrorMedian& median) {
  return fmt::format("{},{},{}", Cell(median.value), Cell(median.ci95.low), Cell(median.ci95.high));
}

}  // namespace pickbed
