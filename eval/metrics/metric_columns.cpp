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
  const std::string help = std::string(row.title) + ": " + row.help;
  const ShownUnit shown = ShownUnitOf(row);
  columns_.push_back(units == MetricUnits::kStored
                         ? Column{key, {key, help, row.unit}, 1}
                         : Column{key, {ShownKey(row), help, shown.name}, shown.Factor()});
}

ResultColumns MetricColumns::Columns() const {
  ResultColumns columns;
  for (const Column& column : columns_) columns.push_back(column.shown);
  return columns;
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
