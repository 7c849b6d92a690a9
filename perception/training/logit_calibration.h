#pragma once

// Maps the logits of a verifier to probabilities that agree with labelled poses (Platt,
// "Probabilistic Outputs for Support Vector Machines", 1999).

#include <vector>

#include "perception/verify/pose_features.h"

namespace pickbed::perception {

// Score of a reported pose, and whether the pose is right.
struct ScoredPose {
  double logit = 0;
  bool right = false;
};
// Returns the calibration that maps scores of an uncalibrated verifier to the shares of right
// poses. A prior towards the identity limits the change if there are few poses.
Calibration Calibrate(const std::vector<ScoredPose>& poses);

}  // namespace pickbed::perception
