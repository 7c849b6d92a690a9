#pragma once

// Compares the hypotheses of one attempt with the true instances.

#include <vector>

#include "eval/trial/instance_matcher.h"
#include "eval/trial/trial_records.h"
#include "perception/pose_hypothesis.h"
#include "scenes/camera/camera.h"

namespace pickbed::eval {

// A hypothesis of an estimator and its comparison with ground truth.
struct ScoredHypothesis {
  PoseHypothesis estimate;
  HypothesisRecord record;  // pose in the world and pose errors
  int recalled = -1;        // index of the instance that it recalls, -1 = none
  int nearest = -1;  // index of the instance with the nearest mean vertex, of any object; -1 = none
};

// Pose errors and recall of one attempt.
struct AttemptScore {
  std::vector<ScoredHypothesis> hypotheses;  // in the order given
  std::vector<InstanceRecord> instances;     // in the order of truth.instances()

  std::vector<HypothesisRecord> Records() const;
};

// Compares each hypothesis with the nearest instance (MSSD) of its own object. If there is none,
// its `instance` is -1 and its errors are infinite. An instance is recalled if a hypothesis is
// correct for it. In order of falling score, each hypothesis recalls the nearest instance that is
// still free, so that no hypothesis counts twice.
//
// Pose errors and recall compare poses in the camera frame, so they do not contain the hand-eye
// error. `calibrated_X_WC` is the camera pose that the cell assumes. HypothesisRecord::X_WO and
// X_OE use it, since the robot moves to this pose.
AttemptScore ScoreAgainstTruth(const InstanceMatcher& truth, const Camera& camera,
                               const Pose& calibrated_X_WC,
                               const std::vector<PoseHypothesis>& hypotheses);
// Same for an exact hand-eye calibration.
AttemptScore ScoreAgainstTruth(const InstanceMatcher& truth, const Camera& camera,
                               const std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed::eval
