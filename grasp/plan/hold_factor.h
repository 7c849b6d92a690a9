#pragma once

// Rates how well a hand holds the weight of an object in the orientation in which it lifts it.
//
// Candidates are rated without a pose in the world. A cup on the end of a bottle that hangs
// straight down carries a pull only; if the bottle is tilted, the weight bends the lip.

#include "grasp/gripper.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

// Returns a factor 0..1 of the score: 1 if the hold is much stronger than the weight times
// `lift_load`, 1/2 if it is as strong. `X_OG`: the hand at the object. `X_WO`: pose of the object
// in the world, z up.
double HoldFactor(const Gripper& gripper, const ObjectModel& object, const Pose& X_OG,
                  const Pose& X_WO, double lift_load);

}  // namespace pickbed::grasp
