#pragma once

// Statistics of the instances that a gripper held: hold tests and drops.

#include <vector>

#include "eval/trial/trial.h"

namespace pickbed::eval {

// Results of the hold tests of a run (policy.retention_g).
struct RetentionStatistics {
  int picks = 0;  // picks with a test
  double min_g = 0, median_g = 0;
};

RetentionStatistics RetentionOf(const std::vector<TrialResult>& trials);

// Lifted instances that left the hand before they were set down.
struct DropTimes {
  int drops = 0;
  double median_s = 0;  // from the end of the lift to the drop
};

DropTimes DropTimesOf(const std::vector<TrialResult>& trials);

}  // namespace pickbed::eval
