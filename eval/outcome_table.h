#pragma once

// Outcomes of grasps as cells of picks.csv, and as rates under each rule of success side by side.

#include <array>
#include <string>
#include <vector>

#include "eval/statistics.h"
#include "eval/trial.h"
#include "grasp/success_rules.h"

namespace pickbed {

// Successes of all executed grasps of a run by one rule, with the interval over scenes.
struct RuleRate {
  SuccessRule rule = SuccessRule::kContact;
  int successes = 0, attempts = 0;
  Interval ci95;
  double rate() const { return attempts > 0 ? static_cast<double>(successes) / attempts : 0; }
};

// In the rules' order.
std::array<RuleRate, kSuccessRules> RatesByRule(const std::vector<TrialResult>& trials);

// Names of the cells below, with a comma before each.
std::string OutcomeHeader();
// Of a look without an executed grasp all are empty. Force and torque are in G; lengths in mm,
// angles in degrees.
std::string OutcomeCells(const PickRecord& pick);

}  // namespace pickbed
