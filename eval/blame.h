#pragma once

// Charges a pick to the one stage that lost it.

#include <vector>

#include "eval/metrics.h"
#include "eval/trial.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

// What a judge knows of a look.
struct LookTruth {
  const Scene& scene;  // before the pick
  const std::vector<MetricModel>& models;
  const Camera& camera;
};

// The loss of an executed pick; kNone when it succeeded. A wrong belief is to blame before the
// grasp is: what the hand did at a wrong pose says nothing, unless physics broke or a part of
// another kind came along. Of the belief's makers the last is to blame that had a right pose in
// hand: the final refiner, then the suppression, then the search.
Loss LossOf(const PickRecord& record, const PoseHypothesis& chosen, const LookTruth& truth);

}  // namespace pickbed
