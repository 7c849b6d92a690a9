#pragma once

// What an estimator says: this part stands there, with this much confidence.

#include <optional>
#include <vector>

#include "scenes/object_model.h"
#include "scenes/pose.h"

namespace pickbed {

// How well a pose agrees with the depth image; shares of the model points that face the camera.
struct FitReport {
  double inlier_share = 0;    // seen where the model says
  double hidden_share = 0;    // something stands before it
  double violated_share = 0;  // the camera looked through where the model should be
  double residual_m = 0;      // rms point-to-plane of the inliers
  double conditioning = 0;    // of the final refiner, see IcpReport; 0 = slides or was not refined
  bool refinement_kept = true;  // false: the final refiner made it worse and was undone
};

struct PoseHypothesis {
  int object = 0;  // index into the ObjectSet
  Pose X_CO = Pose::Identity();
  double score = 0;  // estimate of P(pose right), 0..1; hypotheses are ranked by it
  FitReport fit;
  // Where it comes from, so that a lost pick can be charged to the stage that lost it.
  std::optional<Pose> unrefined_X_CO = {};  // before the final refiner changed it
  std::vector<Pose> suppressed_X_CO = {};   // of weaker ones of the same object that gave way
};

}  // namespace pickbed
