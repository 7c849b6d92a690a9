#pragma once

// When the picking of a bin ends, and what a pick costs in time: two groups of a scenario's
// settings. Adding a policy is one row in policy.cpp.

#include <span>
#include <string>

#include "scenes/settings.h"

namespace pickbed {

struct PolicySpec {
  std::string stop = "until_empty";  // a row of PolicyTable()
  int max_failures_in_row = 2;
  int max_picks = 0;                   // 0 = no limit
  std::string ranking = "quality";     // of planned grasps: a row of grasp/plan.h's table
  std::string success = "right_part";  // what counts: a row of grasp/success_rules.h's table
  void Visit(SettingsVisitor& v);
};

// Of one look at the bin and the move that follows it, one after the other, for picks per hour.
// They change nothing of what happens in a trial.
struct CycleSpec {
  double sense_s = 0.5;
  double compute_s = 0;  // estimate and plan; 0 = as measured on this machine
  double move_s = 6;     // approach to place and back to where it waits
  void Visit(SettingsVisitor& v);
};

// How a trial stands after its looks so far. A look is a pick that was wanted: it brings a part,
// fails, or finds no grasp.
struct PolicyState {
  int looks = 0;
  int failures_in_row = 0;  // looks without a part since the last success
  bool grasp_found = true;  // by the last look
};

struct PolicyRow {
  const char* name;
  const char* help;
  // Whether a bin that still holds parts is given up: what the last look lost ends the trial.
  bool (*gives_up)(const PolicyState& state, const PolicySpec& policy);
  int most_looks = 0;  // 0 = no limit of its own
};
std::span<const PolicyRow> PolicyTable();

// Throws InputError with the known names.
const PolicyRow& PolicyNamed(const std::string& name);

}  // namespace pickbed
