#include "eval/metrics/interval_json.h"

#include <cmath>

namespace pickbed::eval {
namespace {

constexpr char kMissing[] = "_missing";

nlohmann::ordered_json EndOf(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

void AddInterval(nlohmann::ordered_json& json, const std::string& key, const Interval& interval) {
  if (interval.is_known()) {
    json[key] = {EndOf(interval.low), EndOf(interval.high)};
    return;
  }
  json[key] = nullptr;
  json[key + kMissing] = kTooFewBins;
}

ResultColumns IntervalKeys(const std::string& key, const std::string& help,
                           const std::string& unit) {
  return {{key, help, unit},
          {key + kMissing, "reason why the interval before it is null; only in that case"}};
}

}  // namespace pickbed::eval
