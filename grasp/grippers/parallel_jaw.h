#pragma once

// Two coupled fingers that close along x of G with a force limit (sim/hand_joints.h).

#include <optional>
#include <string>

#include "grasp/gripper.h"

namespace pickbed {

// Throws InputError: pads that cannot reach past the palm, or a clearance that eats the stroke.
void CheckParallelJaw(const GripperSpec& spec, const std::string& source);

// The part's width and the clearance on each side; nullopt beyond the stroke.
std::optional<double> ParallelJawApproachOpening(const GripperSpec& spec, double width_m);

}  // namespace pickbed
