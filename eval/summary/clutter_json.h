#pragma once

// Clutter of a scene as text, for the console and for other programs.

#include <string>

#include "eval/metrics/result_columns.h"
#include "eval/trial/clutter.h"

namespace pickbed::eval {

inline constexpr char kClutterFile[] = "clutter.json";

// Returns the statistics as JSON with the keys of ClutterKeys().
std::string ClutterJson(const ClutterStatistics& clutter, const std::string& gripper);
ResultColumns ClutterKeys();

// Returns the statistics as three lines of console text.
std::string ClutterText(const ClutterStatistics& clutter, const std::string& gripper);

}  // namespace pickbed::eval
