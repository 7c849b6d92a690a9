#pragma once

// Columns of the recorded metrics in a CSV file.

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "eval/metrics/metric_table.h"
#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

enum class MetricUnits { kStored, kShown };  // MetricKey or ShownKey

class MetricColumns {
 public:
  // Columns with a fixed place in the line. `first` as in MetricsIn().
  static MetricColumns Placed(MetricUnits units,
                              std::initializer_list<std::string_view> first = {});
  // Columns of all other recorded metrics, for the end of the line.
  static MetricColumns AtEnd(MetricUnits units);

  ResultColumns Columns() const;
  // Each cell begins with a comma. A metric that was not recorded has an empty cell.
  std::string Cells(const MetricValues& values) const;
  std::string EmptyCells() const { return std::string(columns_.size(), ','); }

 private:
  struct Column {
    std::string key;
    ResultColumn shown;
    double factor = 1;
  };
  void Add(const MetricRow& row, MetricUnits units);

  std::vector<Column> columns_;
};

}  // namespace pickbed::eval
