#pragma once

// Outcomes of grasps as cells of attempts.csv, and the success rates of all success rules.

#include <array>
#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"
#include "grasp/outcome.h"

namespace pickbed::eval {

// Success rate of all executed grasps of a run by one rule; scenes are the units of the interval.
struct RuleRate {
  SuccessRule rule = SuccessRule::kContact;
  int successes = 0, executed_grasps = 0;
  Interval ci95;
  double rate() const {
    return executed_grasps > 0 ? static_cast<double>(successes) / executed_grasps : 0;
  }
};

// Returns one rate per rule, in the order of SuccessRule.
std::array<RuleRate, kSuccessRules> RatesByRule(const std::vector<TrialResult>& trials);

// Returns the columns of OutcomeCells().
ResultColumns OutcomeColumns();
// Returns the outcome of an attempt as cells, each preceded by a comma; all cells are empty without
// an executed grasp. Force (N) and torque (N m) are in frame G, lengths in mm and angles in
// degrees.
std::string OutcomeCells(const AttemptRecord& attempt);

}  // namespace pickbed::eval
