#pragma once

// How cluttered bins are, as text: of one bin (`pickbed drop`) or of the bins of a run before the
// first pick.

#include <span>
#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/trial/clutter.h"
#include "eval/trial/trial_records.h"

namespace pickbed::eval {

inline constexpr char kClutterFile[] = "clutter.json";

// Sums over bins, and the mean fill level.
struct ClutterSummary {
  int bins = 0;
  int instances = 0;
  double fill_level = 0;     // see sim/drop/fill_level.h
  std::vector<int> layers;   // instances in each layer, from the top
  std::vector<int> in_view;  // wanted instances in each of InViewNames()
  int counted = 0;           // wanted instances with at least kCountedVisibility
  int tested = 0;            // counted instances for which a grasp was planned
  int graspable = 0;         // tested instances with a grasp that meets nothing
};

// Summarizes one bin.
ClutterSummary ClutterOfBin(const ClutterStatistics& clutter);
// Summarizes the bins of a run before their first pick. Occlusion trials and trials of earlier
// versions are left out.
ClutterSummary ClutterOfTrials(std::span<const TrialResult> trials);

// Returns the content of clutter.json, or of the key `clutter` in summary.json. `gripper`: name of
// the gripper that the graspable instances refer to; it is left out if empty.
std::string ClutterJson(const ClutterSummary& clutter, const std::string& gripper);
// Returns the keys of ClutterJson().
ResultColumns ClutterKeys();
// Returns the same as sentences for people, one per line.
std::string ClutterText(const ClutterSummary& clutter, const std::string& gripper);

}  // namespace pickbed::eval
