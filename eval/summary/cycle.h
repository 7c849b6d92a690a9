#pragma once

// Cycle time and picks per hour of a cell. Each image costs capture and computation time, whatever
// the number of picks that use it. Each executed grasp costs a motion, whether it delivers an
// instance or not. The times follow each other, or they overlap (CycleSpec::overlap).

#include <span>

#include "eval/trial/trial.h"
#include "scenes/scenario/policy.h"

namespace pickbed::eval {

// Mean times per picked instance. The times of failed attempts are distributed over the picks.
struct CycleTime {
  double sense_s = 0, compute_s = 0;
  double move_s = 0;     // with the tool changes
  int tool_changes = 0;  // grasps with another gripper than the grasp before
  // Capture and computation behind the motion of the pick before; 0 without overlap. The second
  // value is without a measured computing time.
  double hidden_s = 0, stated_hidden_s = 0;
  // True if compute_s was measured on this machine. It must not go into a results file then.
  bool measured = false;
  double pick_s() const { return sense_s + compute_s + move_s - hidden_s; }
  // Without a measured computing time, so that equal runs give equal numbers.
  double stated_pick_s() const {
    return sense_s + (measured ? 0 : compute_s) + move_s - stated_hidden_s;
  }
  double picks_per_hour() const { return pick_s() > 0 ? 3600 / pick_s() : 0; }
  double stated_picks_per_hour() const { return stated_pick_s() > 0 ? 3600 / stated_pick_s() : 0; }
};

// Computes the cycle time of a run; all times are zero if nothing was picked. If spec.compute_s is
// 0, uses the times of the stages "estimate" and "plan" of the trials.
//
// With overlap, an image is captured when the arm has left the bin after the pick before. Then
// min(sense_s + compute_s, move_s - in_bin_s) is hidden behind the motion. So a pick with its own
// image takes in_bin_s + max(sense_s + compute_s, move_s - in_bin_s) instead of sense_s + compute_s
// + move_s. The first image of a bin, and one after an attempt without a grasp, have no motion to
// hide behind.
CycleTime CycleTimeOf(std::span<const TrialResult> trials, const CycleSpec& spec);

}  // namespace pickbed::eval
