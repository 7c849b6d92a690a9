#pragma once

// Result type of every pose estimator: an object pose with a confidence and a depth-fit report.

#include <optional>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/ids.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

// Agreement of a pose with the depth image. Shares are fractions of the model points that face the
// camera.
struct FitReport {
  double inlier_share = 0;    // the observed surface agrees with the model point
  double hidden_share = 0;    // occluded by something in front, or outside the image
  double violated_share = 0;  // the reading is behind the model point, which contradicts the pose
  double residual_m = 0;      // rms point-to-plane distance of the inliers
  // From the final refiner, see IcpResult. 0 = the pose can slide, or it was not refined.
  double reciprocal_condition_number = 0;
  bool refinement_kept = true;  // false: the final refiner made the pose worse and was undone
};

// One estimated object pose. Hypotheses are ranked by their score.
struct PoseHypothesis {
  ObjectId object{0};  // index into the ObjectSet
  Pose X_CO = Pose::Identity();
  double score = 0;  // estimated probability that the pose is right, 0..1
  FitReport fit;
  // Provenance: failure attribution uses it to find the stage that lost a pick.
  std::optional<Pose> unrefined_X_CO = {};  // pose before the final refiner changed it
  std::vector<Pose> suppressed_X_CO = {};   // weaker poses of this object that this one suppressed
  // Score of the estimator before its calibration; none = not calibrated.
  std::optional<double> raw_score = {};
};

}  // namespace pickbed::perception
