#pragma once

// Point pair features as their users run them (Drost et al. 2010 in OpenCV's surface_matching, with
// its ICP): the baseline that learned descriptors have to beat.

#include <memory>

#include "perception/pose_estimator.h"

namespace pickbed {

struct PpfOptions {
  double model_sampling = 0.07;   // share of the model's diameter
  double scene_step = 0.1;        // share of the sampled scene points that vote
  double scene_distance = 0.022;  // sampling of the scene, share of its bounding box
  double scene_voxel_m = 0.003;   // one scene point of a voxel goes in
  // Poses nearer than this are averaged. OpenCV's defaults read the relative sampling step as
  // metres, which merges everything, so both are always set.
  double cluster_m = 0.008;
  double cluster_deg = 15;
  int max_poses = 60;  // refined and scored, a frame and object
  int icp_iterations = 30;
  float icp_tolerance = 0.005f;
  float icp_rejection = 2.5f;  // in sigmas of the residual
  int icp_levels = 4;
  double full_support = 0.3;  // share of inliers from which a score is not lowered for lack of them
};

std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
