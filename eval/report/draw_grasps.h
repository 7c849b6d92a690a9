#pragma once

// One picture that shows how a gripper may hold a part: the best grasps from three sides, and how
// the qualities of all of them are spread.

#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/image.h"
#include "scenes/object_model.h"

namespace pickbed {

// Throws InputError when there is no candidate to be drawn.
Image<Rgb8> GraspSheet(const ObjectModel& model, const GripperSpec& gripper,
                       const std::vector<GraspCandidate>& candidates);

// Indices of the best (robust, then epsilon), up to `wanted`, no two of them alike, best first.
std::vector<int> GraspsToDraw(const std::vector<GraspCandidate>& candidates, int wanted,
                              double part_diameter_m);

}  // namespace pickbed
