#pragma once

// The executed picks of a data set as rows of executed_picks.csv: one line per image, method and
// pick.

#include <limits>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "scenes/base/ids.h"
#include "scenes/scenario/failure_reason.h"

namespace pickbed::eval {

// Errors of an estimated pose by the BOP definitions. Infinite if no instance of the object is in
// the image; NaN without a pose.
struct BopErrors {
  double vsd = std::numeric_limits<double>::quiet_NaN();  // mean over the tolerances of BOP
  double mssd_m = std::numeric_limits<double>::quiet_NaN();
  double mspd_px = std::numeric_limits<double>::quiet_NaN();  // not scaled to a width of 640 px
  double add_m = std::numeric_limits<double>::quiet_NaN();
  double adi_m = std::numeric_limits<double>::quiet_NaN();
};

// A pick that was requested of one method in one image.
struct ExecutedPick {
  std::string method;
  int scene_id = 0;
  int image_id = 0;
  int pick = 0;       // number of the pick, from 0
  int object_id = 0;  // of the executed pose; 0 = no grasp was found
  double score = std::numeric_limits<double>::quiet_NaN();  // of the pose, as in the results file
  InstanceId instance = kNoInstance;                        // that the pose matches
  double visible_fraction = std::numeric_limits<double>::quiet_NaN();  // of this instance
  BopErrors errors;  // against the nearest instance of the object
  bool success = false;
  FailureReason failure = FailureReason::kNone;

  bool executed() const { return object_id > 0; }
};

// Returns the columns of executed_picks.csv.
ResultColumns PicksColumns();
// Returns the line of a pick, with its line end. All numbers have all digits.
std::string PickRow(const ExecutedPick& pick);
// Reads complete lines of executed_picks.csv after the header; stops at the first line that is not
// one, such as a line that a kill cut off.
std::vector<ExecutedPick> ReadPickRows(const std::string& text);

}  // namespace pickbed::eval
