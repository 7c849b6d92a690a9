#pragma once

// Which instances rest on which, by their poses. An instance under others is wedged and
// carries their weight, so it slips out of the hand more often.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "grasp/layer.h"

namespace pickbed::grasp {

// Returns for each instance the indices of the instances above it, in ascending order. One instance
// is above another if it is the higher one in more cells of their common floor plan than it is the
// lower one. `surfaces_W` has the surface points of one instance per element, one point per column,
// in W; `cell_m` is the size of a cell and should exceed the spacing of the points.
std::vector<std::vector<int>> InstancesAbove(std::span<const Eigen::Matrix3Xd> surfaces_W,
                                             double cell_m);

}  // namespace pickbed::grasp
