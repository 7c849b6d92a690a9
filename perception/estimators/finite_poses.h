#pragma once

// Check at the boundary between an estimator and the stages that use its poses.

#include <vector>

#include "perception/pose_hypothesis.h"

namespace pickbed::perception {

// Removes hypotheses whose pose, score or raw score is not finite, and counts them
// (scenes/base/finite_counts.h).
void DropNotFinite(std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed::perception
