#pragma once

// Space that an image does not show, because a surface is in front of it. Instances that the
// estimator cannot see are in this space, so a hand that enters it may meet one.

#include <Eigen/Core>
#include <span>

#include "grasp/gripper.h"
#include "scenes/camera/camera.h"
#include "scenes/geometry/pose.h"
#include "scenes/image/image.h"

namespace pickbed::grasp {

class HiddenSpace {
 public:
  // - depth_m: depth image, m; gaps count as the nearest surface at their borders
  // - X_CB: frame of the planner in the camera
  // - behind_m: only what is further than this behind a surface is hidden, because the hand and the
  //   surfaces of instances in view are not exactly where they are measured
  HiddenSpace(const Image<float>& depth_m, const CameraIntrinsics& intrinsics, const Pose& X_CB,
              double behind_m);

  // Returns the hidden part of the volume of the boxes (in G) of a hand at X_BG, in m^3. It is
  // sampled in steps of `step_m`. What is outside the image is not hidden.
  double HiddenVolume_m3(std::span<const AxisAlignedBox> boxes_G, const Pose& X_BG,
                         double step_m) const;

  // Returns the mean depth of the fingers, or of the stem of a cup, in hidden space, m: the hidden
  // volume of the boxes of HandSweep(), divided by the area of the fingers or the stem across the
  // approach. 0 for a hand without fingers or stem.
  double MeanDepth_m(std::span<const AxisAlignedBox> sweep_G, const Pose& X_BG,
                     double step_m) const;

 private:
  Image<float> depth_m_;
  CameraIntrinsics intrinsics_;
  Pose X_CB_;
  double behind_m_;
};

}  // namespace pickbed::grasp
