#pragma once

// Keeps a consistent set: no two hypotheses claim the same pixels or lie in each other, the better
// one wins.

#include <span>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

struct SuppressOptions {
  double claim_m = 0.004;         // a pixel this near to the model's surface is claimed by it
  double max_shared_share = 0.4;  // of the weaker one's claimed pixels
  int pixel_stride = 2;           // only every so many pixels of a row and rows are looked at
  // Poses that are right to a few hundredths of the diameter may touch, and overlap that much.
  double max_penetration_share = 0.08;  // of the smaller diameter
};

// `hypotheses` in any order; the result is sorted by falling score (of equals the earlier first).
// One that claims no pixel at all is dropped; one that gives way is noted in suppressed_X_CO of the
// one that claims most of its pixels or that it lies in, where that is of the same object. Where
// `instances` are told, only so many of an object are kept, and what is over keeps nothing else
// away. `models` and `instances` by object index. Throws InputError where they are not as many.
std::vector<PoseHypothesis> SuppressDuplicates(const OrganizedCloud& cloud,
                                               const std::vector<ModelPoints>& models,
                                               std::vector<PoseHypothesis> hypotheses,
                                               const SuppressOptions& options = {},
                                               std::span<const int> instances = {});

}  // namespace pickbed
