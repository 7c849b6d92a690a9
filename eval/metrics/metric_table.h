#pragma once

// Table of the metrics. A new metric needs one file with its function in eval/metrics and one row
// in metric_table.cpp. It then has a value for each hypothesis in the results store, a column in
// attempts.csv and hypotheses.csv, a histogram in the report, and a median in `pickbed compare`.

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "eval/metrics/metric_values.h"
#include "eval/metrics/pose_errors.h"

namespace pickbed::eval {

// Input of all metrics. Poses map O to the camera frame.
struct MetricInput {
  const MetricModel& model;
  const CameraIntrinsics& camera;
  const Pose& X_est;
  const Pose& X_true;
  const ToleranceModel* tolerance = nullptr;          // of the object, if it has one
  std::optional<double> known_mssd_m = std::nullopt;  // saves the computation of MSSD
};

// Outputs that show a metric, as bits.
enum MetricOutput : unsigned {
  kListed = 1,     // `pickbed list metrics`
  kPredictor = 2,  // predictors of pick success in a tolerance report; there is no camera
  kRecorded = 4,   // results store and CSV files; there is no tolerance model
  kReported = 8,   // histogram in the report of a run
  kCompared = 16,  // paired difference of the median in `pickbed compare`
  // The CSV columns have their place among the others. Other metrics have theirs at the end of the
  // line, so that the columns of earlier versions keep their positions.
  kPlacedColumn = 32,
};
inline constexpr unsigned kUsualOutputs = kListed | kPredictor | kRecorded | kReported | kCompared;

// Metric with its function and where it is shown. Name and unit together are unique.
struct MetricRow {
  const char* name;
  const char* unit;   // of the value that `compute` returns; "" for a plain number
  const char* title;  // in pages and tables, such as "MSSD"
  const char* help;
  double (*compute)(const MetricInput& input);
  unsigned outputs = kUsualOutputs;

  bool IsIn(MetricOutput output) const { return (outputs & output) != 0; }
};
// Returns all metrics, in the order of the columns.
std::span<const MetricRow> MetricTable();

// Returns the metrics of an output in table order, except that those with a key in `first` come
// first, in this order.
std::vector<MetricRow> MetricsIn(MetricOutput output,
                                 std::initializer_list<std::string_view> first = {});

// Name and unit, such as "mssd_m": the key of the metric in records and in the results store.
std::string MetricKey(const MetricRow& row);

// Returns all recorded metrics of an estimate.
MetricValues RecordedMetrics(const MetricInput& input);
// Returns the same metrics with infinite values, for a hypothesis that matches no instance.
MetricValues InfiniteMetrics();

// Unit in which pages and attempts.csv show a metric: value * numerator / denominator.
struct ShownUnit {
  std::string name;  // such as "mm" for "m"
  double numerator = 1, denominator = 1;
  int digits = 4;  // decimals in pages

  double Factor() const { return numerator / denominator; }
};
// Returns mm for m, deg for rad, and other units unchanged.
ShownUnit ShownUnitOf(const MetricRow& row);
// Name and shown unit, such as "mssd_mm".
std::string ShownKey(const MetricRow& row);
// Title and shown unit, such as "MSSD, mm".
std::string ShownName(const MetricRow& row);

// Adds a row to the table while the object exists. For tests of the code that uses the table; no
// other thread may use the table meanwhile.
class ScopedMetric {
 public:
  explicit ScopedMetric(const MetricRow& row);
  ~ScopedMetric();
  ScopedMetric(const ScopedMetric&) = delete;
  ScopedMetric& operator=(const ScopedMetric&) = delete;
};

}  // namespace pickbed::eval
