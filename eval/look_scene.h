#pragma once

// The scene that a recorded look saw, made again without an estimator: the drop from the scenario's
// seed, then the recorded grasps of the looks before, or the series of an occlusion trial.

#include <string>

#include "eval/trial.h"
#include "eval/virtual_cell.h"
#include "grasp/gripper.h"

namespace pickbed {

struct LookSetup {
  VirtualCell& cell;
  const GripperSpec& gripper;
  std::string success_rule;  // PolicySpec::success
};

// Of trial.picks[look]. Throws InputError when it is not the stored one: other meshes, another
// program, another kind of CPU.
Scene SceneOfLook(const TrialResult& trial, size_t look, const LookSetup& setup);

}  // namespace pickbed
