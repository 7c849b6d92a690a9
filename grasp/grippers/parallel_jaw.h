#pragma once

// Two coupled fingers that close along x of G with a force limit (sim/hand_joints.h).

#include "grasp/gripper.h"

namespace pickbed {

MechanismRow ParallelJawRow();

}  // namespace pickbed
