#pragma once

// Matches the hypotheses of one attempt with the true instances and computes their pose errors.

#include <vector>

#include "eval/metrics/pose_errors.h"
#include "eval/trial/trial_records.h"
#include "perception/pose_hypothesis.h"
#include "scenes/base/ids.h"
#include "scenes/camera/camera.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// Pose errors and recall of one attempt.
struct AttemptScore {
  std::vector<HypothesisRecord> hypotheses;  // in the order given
  std::vector<InstanceRecord> instances;     // in the order of the scene
  std::vector<int> taken;                // by hypothesis: index of the instance that it recalls,
                                         // -1 = none
  std::vector<ObjectId> nearest_object;  // by hypothesis: object of the instance whose mean
                                         // vertex is nearest, whatever its object
};

// Compares each hypothesis with the nearest instance (MSSD) of its own object. If the scene has
// none, its `instance` is -1 and its errors are infinite. An instance is recalled if a hypothesis
// is correct for it. In order of falling score, each hypothesis recalls the nearest instance that
// is still free, so that no hypothesis counts twice. `visible_fractions` are by scene.objects[i].
AttemptScore ScoreAgainstTruth(const Scene& truth, const std::vector<double>& visible_fractions,
                               const std::vector<MetricModel>& models, const Camera& camera,
                               const std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed::eval
