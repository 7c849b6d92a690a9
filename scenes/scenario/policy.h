#pragma once

// Two groups of a scenario's settings: when the picking of a bin ends, and the duration of a pick.
// A new policy is one row in policy.cpp.

#include <span>
#include <string>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// Last resort when no grasp is found: the closed hand pushes through the clutter. It counts and
// costs as a failed pick.
struct StirSpec {
  int max = 0;    // in a trial, 0 = never
  int after = 1;  // attempts in a row without a grasp
  void Visit(SettingsVisitor& v);
};

// Settings of the picking policy.
struct PolicySpec {
  std::string stop = "until_empty";  // a row of PolicyTable()
  int max_failures_in_row = 2;
  int max_attempts = 0;             // 0 = no limit
  std::string ranking = "quality";  // order of planned grasps: a row of grasp/plan/plan.h's table
  StirSpec stir;
  std::string success = "right_instance";  // success rule: a row of grasp/outcome.h's table
  void Visit(SettingsVisitor& v);
};

// Durations of one attempt, from which picks per hour are computed. Image, computation and motion
// follow each other. They have no influence on the trial.
struct CycleSpec {
  double sense_s = 0.5;      // capture of one image
  double compute_s = 0;      // estimation and planning; 0 = as measured on this machine
  double move_s = 6;         // approach, transport to the place, and return to the waiting position
  double tool_change_s = 5;  // if a pick needs another gripper than the pick before
  void Visit(SettingsVisitor& v);
};

// State of a trial after its attempts so far. An attempt delivers an instance, fails, or finds no
// grasp.
struct PolicyState {
  int attempts = 0;
  int failures_in_row = 0;  // attempts without success since the last success
  bool grasp_found = true;  // in the last attempt; also if the bin was stirred or may be later
};

// A stop policy: name, one line of help and its rule.
struct PolicyRow {
  const char* name;
  const char* help;
  // Returns whether the trial ends although wanted instances are left in the bin. The failure
  // reason of the last attempt is then the reason for the end.
  bool (*gives_up)(const PolicyState& state, const PolicySpec& policy);
  int max_attempts = 0;  // 0 = PolicySpec::max_attempts applies
};
// Returns all stop policies, in the order of the help.
std::span<const PolicyRow> PolicyTable();

// Returns the policy of that name. Throws InputError with the known names if there is none.
const PolicyRow& PolicyNamed(const std::string& name);

}  // namespace pickbed::scenes
