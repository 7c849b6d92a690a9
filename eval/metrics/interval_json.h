#pragma once

// Intervals in JSON files. JSON has no infinity, so an unknown interval is null, with a key that
// says why.

#include <nlohmann/json.hpp>
#include <string>

#include "eval/metrics/result_columns.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {

// Adds "KEY": [low, high], with null for an infinite end. An unknown interval adds "KEY": null and
// "KEY_missing": "too few bins".
void AddInterval(nlohmann::ordered_json& json, const std::string& key, const Interval& interval);

// Returns the two columns of such a key. `help` describes the interval.
ResultColumns IntervalKeys(const std::string& key, const std::string& help,
                           const std::string& unit = "");

}  // namespace pickbed::eval
