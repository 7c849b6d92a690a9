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
  int max = 0;             // in a trial, 0 = never
  int after = 1;           // attempts in a row without a grasp
  int after_failures = 0;  // failed attempts in a row since the last success or stir, 0 = never
  void Visit(SettingsVisitor& v);
};

// Settings of the picking policy.
struct PolicySpec {
  std::string stop = "until_empty";  // a row of PolicyTable()
  int max_failures_in_row = 2;
  int max_attempts = 0;  // 0 = no limit
  // Failed grasps at a place after which no grasp there is executed until a stir; 0 = no limit.
  int max_failures_at_place = 0;
  // Maximum number of picks after one image. Only picks that cannot disturb each other share an
  // image, see grasp/plan/image_picks.h. A failed pick is followed by a new image.
  int picks_per_image = 1;
  std::string ranking = "quality";  // order of planned grasps: a row of grasp/plan/plan.h's table
  StirSpec stir;
  // For the ranking "tolerance": folder of tolerance maps (`pickbed tolerance`), relative to the
  // working directory, and the expected error of an estimated pose.
  std::string tolerance_maps;
  double pose_error_mm = 2;
  double pose_error_deg = 2;
  // Whether grasps are rejected whose object would meet a wall while it is lifted
  // (grasp/plan/lift_clearance.h), and the distance that it keeps from the walls.
  bool check_lift = false;
  double lift_clearance_mm = 0;
  // Largest load of a hold test after each successful pick, in multiples of g; 0 = no test. The
  // test repeats the pick in a copy of the scene, so it changes no result and doubles the physics.
  double retention_g = 0;
  std::string retention_load = "weight";   // weight | lateral
  std::string success = "right_instance";  // success rule: a row of grasp/outcome.h's table
  void Visit(SettingsVisitor& v);
};

// Durations of one attempt, from which picks per hour are computed (eval/summary/cycle.h). They
// have no influence on the trial.
struct CycleSpec {
  double sense_s = 0.5;      // capture of one image
  double compute_s = 0;      // estimation and planning; 0 = as measured on this machine
  double move_s = 6;         // approach, transport to the place, and return to the waiting position
  double tool_change_s = 5;  // if a pick needs another gripper than the pick before
  // Whether the next image is captured and computed once the arm has left the bin, while it moves.
  // Else image, computation and motion follow each other.
  bool overlap = false;
  double in_bin_s = 2;  // share of move_s in which the arm hides the bin; only with `overlap`
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
