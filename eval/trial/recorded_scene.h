#pragma once

// Rebuilds the scene of a recorded attempt without an estimator. The bin is dropped again from the
// scenario's seed, then the recorded grasps of the earlier attempts are executed. For an occlusion
// trial, the series is built again.

#include <string>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/trial.h"
#include "grasp/grippers/tools.h"

namespace pickbed::eval {

// The simulation of the scenario that the recorded trial ran in.
struct AttemptSetup {
  SimulatedCell& cell;
  const Tools& tools;
  std::string success_rule;  // PolicySpec::success
};

// Returns the scene before trial.attempts[attempt]. Throws InputError if it differs from the
// recorded one, because of other meshes, another program version or another kind of CPU.
Scene SceneOfAttempt(const TrialResult& trial, size_t attempt, const AttemptSetup& setup);

}  // namespace pickbed::eval
