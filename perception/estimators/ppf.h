#pragma once

// Point pair features as their users run them (Drost et al. 2010, OpenCV's surface_matching): the
// baseline that learned descriptors have to beat.

#include <memory>

#include "perception/pose_estimator.h"

namespace pickbed {

struct PpfOptions {
  double model_sampling = 0.07;       // share of the model's diameter
  double scene_step = 0.1;            // share of the sampled scene points that vote
  double scene_distance = 0.022;      // sampling of the scene, share of its bounding box
  double scene_voxel_m = 0.003;       // one scene point a voxel goes in
  double cluster_position_m = 0.008;  // OpenCV's default reads a ratio as metres and merges all
  double cluster_rotation_deg = 15;
  int max_poses = 60;  // refined a frame and object
  int icp_iterations = 30;
  double icp_tolerance = 0.005;
  double icp_rejection = 2.5;
  int icp_levels = 4;
};

std::unique_ptr<PoseEstimator> MakePpfEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
