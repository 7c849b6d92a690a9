#pragma once

// Point pair features as their users run them (Drost et al. 2010 in OpenCV's surface_matching, with
// its ICP): the baseline that learned descriptors have to beat. For the same pose proposals with
// the second half of the learned estimator see ppf_verified.h.

#include <memory>

#include "perception/estimators/ppf_matcher.h"
#include "perception/pose_estimator.h"

namespace pickbed {

struct PpfOptions {
  PpfMatchOptions match{.scene_voxel_diameters = 0.04, .cluster_m = 0.008};
  PpfIcpOptions icp;
  int max_poses = 60;         // refined and scored, a frame and object
  double full_support = 0.3;  // share of inliers from which a score is not lowered for lack of them
};

std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup,
                                                const PpfOptions& options);

// Row of the table: mode verified is MakeVerifiedPpfEstimator, the modes fast and hard, which are
// the learned estimator's, are this one. Throws InputError for another mode.
std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
