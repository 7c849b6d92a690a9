#pragma once

// Contact sheet of the grasps of an object with a gripper: the best grasps from several sides, and
// the distributions of the quality measures.

#include <vector>

#include "eval/layer.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/image/image.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

inline constexpr char kGraspSheetFile[] = "grasps.png";

// Draws the sheet. Throws InputError if there are no candidates.
Image<Rgb8> GraspSheet(const ObjectModel& model, const Gripper& gripper,
                       const std::vector<GraspCandidate>& candidates);

// Indices of up to `wanted` best candidates (by robust, then epsilon), best first, without similar
// grasps.
std::vector<int> GraspsToDraw(const std::vector<GraspCandidate>& candidates, int wanted,
                              double object_diameter_m);

}  // namespace pickbed::eval
