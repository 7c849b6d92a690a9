#pragma once

// One bellows with a lip that seals on a part (sim/cup_joint.h). It touches from one side, so that
// a part has no width for it.

#include "grasp/gripper.h"

namespace pickbed {

MechanismRow SuctionCupRow();

}  // namespace pickbed
