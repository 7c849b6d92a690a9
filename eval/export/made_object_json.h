#pragma once

// Result of `pickbed object add` as JSON.

#include <string>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "sim/drop/object_maker.h"

namespace pickbed::eval {

inline constexpr char kMadeObjectFile[] = "made.json";  // in the folder of an object

// `key` identifies everything that the object was made from.
std::string MadeObjectJson(const std::string& key, const MadeObject& made);
// Returns the keys of MadeObjectJson().
ResultColumns MadeObjectKeys();

}  // namespace pickbed::eval
