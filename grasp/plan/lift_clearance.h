#pragma once

// Collision of a held object with the walls of the bin while it is lifted.
//
// The hand lifts straight up, or aside until 1 cm before a wall (grasp/plan/lift_aside.h). So
// whether the object meets a wall depends on its pose and not on the grasp. Vertical walls that an
// object does not touch before the lift are not met during it. A bin that is narrower at its
// opening is: its free space is the box of Bin::inner_size_m, which fits through the opening.

#include "grasp/layer.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

// Returns whether the object at X_BO (in the frame of the bin) comes closer than `clearance_m` to a
// wall while it is lifted straight up above the rim. A negative clearance allows an overlap, for
// poses with an error. Vertices that are above the rim before the lift meet nothing. A bin without
// walls meets nothing.
bool LiftMeetsWall(const Bin& bin, const ObjectModel& object, const Pose& X_BO, double clearance_m);

}  // namespace pickbed::grasp
