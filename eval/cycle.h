#pragma once

// Picks per hour of a cell that looks, computes and moves one after the other: each look costs
// sense and compute, each executed grasp a move, whether it brings a part or not.

#include <span>

#include "eval/trial.h"
#include "scenes/policy.h"

namespace pickbed {

struct CycleTime {
  double sense_s = 0, compute_s = 0, move_s = 0;  // of a part that is picked, with failures shared
  bool measured = false;  // compute_s is this machine's, and no results file may hold it
  double part_s() const { return sense_s + compute_s + move_s; }
  double picks_per_hour() const { return part_s() > 0 ? 3600 / part_s() : 0; }
};

// Of no time at all when nothing was picked. Where the scenario states no compute time it is the
// trials' own, estimate and plan.
CycleTime CycleTimeOf(std::span<const TrialResult> trials, const CycleSpec& spec);

}  // namespace pickbed
