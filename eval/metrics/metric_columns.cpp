#include "eval/metrics/metric_columns.h"

#include <fmt/format.h>

#include <cmath>

namespace pickbed::eval {

MetricColumns MetricColumns::Placed(MetricUnits units,
                                    std::initializer_list<std::string_view> first) {
  MetricColumns columns;
  for (const MetricRow& row : MetricsIn(kRecorded, first)) {
    if (row.IsIn(kPlacedColumn)) columns.Add(row, units);
  }
  return columns;
}

MetricColumns MetricColumns::AtEnd(MetricUnits units) {
  MetricColumns columns;
  for (const MetricRow& row : MetricsIn(kRecorded)) {
    if (!row.IsIn(kPlacedColumn)) columns.Add(row, units);
  }
  return columns;
}

void MetricColumns::Add(const MetricRow& row, MetricUnits units) {
  const std::string key = MetricKey(row);
  columns_.push_back(units == MetricUnits::kStored
                         ? Column{key, key, 1}
                         : Column{key, ShownKey(row), ShownUnitOf(row).Factor()});
}

std::string MetricColumns::Header() const {
  std::string header;
  for (const Column& column : columns_) header += "," + column.name;
  return header;
}

std::string MetricColumns::Cells(const MetricValues& values) const {
  std::string cells;
  for (const Column& column : columns_) {
    const double value = values.Get(column.key);
    cells += std::isnan(value) ? "," : fmt::format(",{}", column.factor * value);
  }
  return cells;
}

}  // namespace pickbed::eval
