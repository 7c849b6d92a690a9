#pragma once

// A choice of candidates that serves every way a part may lie.

#include <functional>
#include <vector>

#include "grasp/grasp.h"

namespace pickbed {

// Up to `wanted` of them: the best of each approach direction in turn, so that some come from above
// however the part lies. Of candidates that are the `same` only the best stays.
std::vector<GraspCandidate> SpreadOverDirections(
    std::vector<GraspCandidate> all, int wanted,
    const std::function<bool(const GraspCandidate&, const GraspCandidate&)>& same);

}  // namespace pickbed
