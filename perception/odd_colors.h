#pragma once

// Parts of one kind in one image are of one colour. A pose whose pixels have another one than those
// of its kind lies on a foreign thing. What colour the part has need not be known, nor what light
// falls on it.

#include <span>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

// Lowers the scores of poses whose colour is odd among the `accepted` of their kind, each of which
// shows another part; says whether there were any. Compared is the chromaticity, which neither
// shading nor the light's strength changes, each distance in units of the kind's own spread: where
// parts of a kind differ in colour none is odd. Nothing is lowered where the image has no colours,
// of a kind of which few are accepted, or where the part has a print (surface_print.h), whose sides
// differ. `models` by object index.
bool LowerOddColors(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
                    std::span<const PoseHypothesis> accepted, std::span<PoseHypothesis> hypotheses);

}  // namespace pickbed
