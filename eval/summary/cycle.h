#pragma once

// Cycle time and picks per hour of a cell that captures, computes and moves in sequence. Each
// attempt costs capture and computation time. Each executed grasp costs a motion, whether it
// delivers an instance or not.

#include <span>

#include "eval/trial/trial.h"
#include "scenes/scenario/policy.h"

namespace pickbed::eval {

// Mean times per picked instance. The times of failed attempts are distributed over the picks.
struct CycleTime {
  double sense_s = 0, compute_s = 0;
  double move_s = 0;     // with the tool changes
  int tool_changes = 0;  // grasps with another gripper than the grasp before
  // True if compute_s was measured on this machine. It must not go into a results file then.
  bool measured = false;
  double pick_s() const { return sense_s + compute_s + move_s; }
  // Without a measured computing time, so that equal runs give equal numbers.
  double stated_pick_s() const { return sense_s + (measured ? 0 : compute_s) + move_s; }
  double picks_per_hour() const { return pick_s() > 0 ? 3600 / pick_s() : 0; }
  double stated_picks_per_hour() const { return stated_pick_s() > 0 ? 3600 / stated_pick_s() : 0; }
};

// Computes the cycle time of a run; all times are zero if nothing was picked. If spec.compute_s is
// 0, uses the times of the stages "estimate" and "plan" of the trials.
CycleTime CycleTimeOf(std::span<const TrialResult> trials, const CycleSpec& spec);

}  // namespace pickbed::eval
