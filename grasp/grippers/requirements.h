#pragma once

// Checks that a gripper can work with a bin and an object. Commands call them before a run.

#include <vector>

#include "grasp/candidates/candidates.h"
#include "grasp/gripper.h"

namespace pickbed::grasp {

// The hand at its narrowest must fit between the walls. Only the boxes below the rim count when the
// hand reaches the floor. Throws InputError with both sizes.
void RequireFitsBin(const Gripper& gripper, const Bin& bin);

// Returns whether the weight of a mass is below the capacity of the gripper.
bool CanCarry(const Gripper& gripper, double mass_kg, double friction);

// The weight of the object must be below the capacity of the gripper. Throws InputError with both
// numbers.
void RequireCanCarry(const Gripper& gripper, const ObjectModel& object);

// Returns whether two contacts at this distance fit between the open fingers. A gripper without
// fingers takes any width.
bool OpensFor(const Gripper& gripper, double width_m);
// Throws InputError with both numbers unless OpensFor().
void RequireOpensFor(const Gripper& gripper, double width_m);

// Returns the candidates of CachedCandidates, at least one. Throws InputError if there is none; the
// message says what the object lacks and names another gripper that can hold it.
std::vector<GraspCandidate> RequireCandidates(const ObjectModel& object, const Gripper& gripper,
                                              const GraspCandidateOptions& options = {});

}  // namespace pickbed::grasp
