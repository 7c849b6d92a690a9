#pragma once

// Values of metrics by key, such as "mssd_m" (MetricKey in eval/metrics/metric_table.h).

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

inline constexpr std::string_view kMssdDiameters = "mssd_diameters";
inline constexpr std::string_view kMssd_m = "mssd_m";
inline constexpr std::string_view kRotation_rad = "rotation_rad";
inline constexpr std::string_view kTranslation_m = "translation_m";

struct MetricValue {
  std::string metric;  // key
  double value = 0;
};

// Metrics of one hypothesis. They are few, so a linear search is faster than a map.
class MetricValues {
 public:
  // Adds or replaces a value.
  void Set(std::string_view metric, double value) {
    for (MetricValue& known : values_) {
      if (known.metric != metric) continue;
      known.value = value;
      return;
    }
    if (values_.empty()) values_.reserve(kUsualCount);
    values_.push_back({std::string(metric), value});
  }
  // Returns NaN if the metric was not recorded.
  double Get(std::string_view metric) const {
    for (const MetricValue& known : values_) {
      if (known.metric == metric) return known.value;
    }
    return std::numeric_limits<double>::quiet_NaN();
  }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

 private:
  static constexpr size_t kUsualCount = 8;
  std::vector<MetricValue> values_;
};

}  // namespace pickbed::eval
