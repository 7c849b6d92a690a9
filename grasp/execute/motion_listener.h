#pragma once

// Reports the motion of an executed grasp, for animations.

#include <functional>

#include "grasp/execute/attempt_world.h"
#include "scenes/bin/bin.h"
#include "sim/hands/hand.h"

namespace pickbed::grasp {

// State of an execution after one step of the physics.
struct MotionState {
  double time_s = 0;  // since the start of the approach
  const AttemptWorld& world;
  const Hand& hand;
  // The table beside the bin, in W, on which the object is set down; null before the carry.
  const AxisAlignedBox* table_W = nullptr;
};

// Called after each step. The state is valid only during the call.
using MotionListener = std::function<void(const MotionState& state)>;

}  // namespace pickbed::grasp
