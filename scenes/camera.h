#pragma once

// Pinhole camera: u = fx * x/z + cx, v = fy * y/z + cy, pixel (0,0) is the CENTRE of the first
// pixel (OpenCV's and BOP's convention). Lens distortion is taken to be removed.

#include <Eigen/Core>

#include "scenes/pose.h"

namespace pickbed {

struct CameraIntrinsics {
  int width = 640;    // px
  int height = 480;   // px
  double fx = 680;    // px
  double fy = 680;    // px
  double cx = 319.5;  // px
  double cy = 239.5;  // px
  friend bool operator==(const CameraIntrinsics&, const CameraIntrinsics&) = default;
};

struct Camera {
  CameraIntrinsics intrinsics;
  Pose X_WC = Pose::Identity();
};

inline Eigen::Vector2d Project(const CameraIntrinsics& k, const Eigen::Vector3d& p_C) {
  return {k.fx * p_C.x() / p_C.z() + k.cx, k.fy * p_C.y() / p_C.z() + k.cy};
}

inline Eigen::Vector3d BackProject(const CameraIntrinsics& k, double u, double v, double depth_m) {
  return {(u - k.cx) / k.fx * depth_m, (v - k.cy) / k.fy * depth_m, depth_m};
}

}  // namespace pickbed
