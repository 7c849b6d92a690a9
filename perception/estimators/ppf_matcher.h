#pragma once

// Point pair features of one part (Drost et al. 2010) by OpenCV's surface_matching, behind a header
// that is free of it.

#include <memory>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "scenes/pose.h"

namespace pickbed {

struct PpfMatchOptions {
  double model_sampling = 0.07;         // share of the model's box, each axis
  double scene_voxel_diameters = 0.06;  // one scene point of a voxel goes in
  double scene_step = 0.1;              // share of those that are reference points: one pose each
  // The scene goes in by square windows of this side, half of it apart, since a pair wider than the
  // part says nothing of it: OpenCV looks it up all the same and finds chance votes. 0 = as a
  // whole.
  double window_diameters = 0;
  // Poses nearer than this are averaged; 0 = none. OpenCV's defaults read the relative sampling
  // step as metres, which merges everything, so both are always set.
  double cluster_m = 0;
  double cluster_deg = 15;
};

struct PpfIcpOptions {
  int iterations = 30;
  float tolerance = 0.005f;
  float rejection = 2.5f;  // in sigmas of the residual
  int levels = 4;
};

class PpfMatcher {
 public:
  PpfMatcher(const ModelPoints& model, const PpfMatchOptions& options);
  ~PpfMatcher();

  // Foreground points with a normal, one of a voxel: row i is x y z nx ny nz in C.
  std::vector<float> SceneRows(const OrganizedCloud& cloud) const;

  // Poses X_CO of the part, those with most votes first within a window.
  std::vector<Pose> Match(const std::vector<float>& scene_rows) const;

  // OpenCV's own ICP. Poses that it loses come back not finite.
  std::vector<Pose> Refine(const std::vector<float>& scene_rows, const std::vector<Pose>& poses,
                           const PpfIcpOptions& options) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
