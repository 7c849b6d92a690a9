#pragma once

// Point pair features as commonly used: Drost et al. 2010 in OpenCV's surface_matching, with its
// ICP. This is the baseline for learned descriptors. ppf_verified.h combines the same pose
// proposals with the candidate refinement and the verifier of the learned estimators.

#include <memory>

#include "perception/estimators/pose_estimator.h"
#include "perception/estimators/ppf_matcher.h"

namespace pickbed::perception {

struct PpfOptions {
  PpfMatchOptions match{.scene_voxel_diameters = 0.04, .cluster_m = 0.008};
  PpfIcpOptions icp;
  int max_poses = 60;         // poses refined and scored, per frame and object
  double full_support = 0.3;  // inlier share below which the score is lowered
  void Visit(SettingsVisitor& v);
};

// Makes the estimator without verifier.
std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup,
                                                const PpfOptions& options);

// Entry of EstimatorTable(). Mode "verified" is MakeVerifiedPpfEstimator. The modes "fast" and
// "accurate" of the learned estimators both give the estimator without verifier.
std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup);

}  // namespace pickbed::perception
