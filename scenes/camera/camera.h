#pragma once

// Pinhole camera: u = fx * x/z + cx, v = fy * y/z + cy. Pixel (0,0) is the CENTER of the first
// pixel (convention of OpenCV and BOP). Images are assumed to be free of lens distortion.
//
//          z (viewing direction)
//         /
//        C------ x, u (columns, right)
//        |
//        y, v (rows, down)

#include <Eigen/Core>

#include "scenes/geometry/pose.h"

namespace pickbed::scenes {

// Image size and parameters of the pinhole projection.
struct CameraIntrinsics {
  int width = 640;    // px
  int height = 480;   // px
  double fx = 680;    // px
  double fy = 680;    // px
  double cx = 319.5;  // px
  double cy = 239.5;  // px
  friend bool operator==(const CameraIntrinsics&, const CameraIntrinsics&) = default;
};

// A camera with its pose in the world. Both directions of the pose are stored, since points are
// projected far more often than cameras move.
class Camera {
 public:
  Camera() = default;
  Camera(const CameraIntrinsics& camera_intrinsics, const Pose& X_WC)
      : intrinsics(camera_intrinsics) {
    SetPose(X_WC);
  }

  const Pose& X_WC() const { return X_WC_; }
  const Pose& X_CW() const { return X_CW_; }
  void SetPose(const Pose& X_WC) {
    X_WC_ = X_WC;
    X_CW_ = X_WC.inverse();
  }

  CameraIntrinsics intrinsics;

 private:
  Pose X_WC_ = Pose::Identity();
  Pose X_CW_ = Pose::Identity();
};

// Returns the pixel (u, v) of a point in C. The depth p_C.z() must not be 0.
inline Eigen::Vector2d Project(const CameraIntrinsics& k, const Eigen::Vector3d& p_C) {
  return {k.fx * p_C.x() / p_C.z() + k.cx, k.fy * p_C.y() / p_C.z() + k.cy};
}

// Returns the point in C (m) that pixel (u, v) shows at depth_m along z.
inline Eigen::Vector3d BackProject(const CameraIntrinsics& k, double u, double v, double depth_m) {
  return {(u - k.cx) / k.fx * depth_m, (v - k.cy) / k.fy * depth_m, depth_m};
}

}  // namespace pickbed::scenes
