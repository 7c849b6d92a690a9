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
#include <string>

#include "scenes/geometry/pose.h"

namespace pickbed::scenes {

// Image size and parameters of the pinhole projection, all in px. Every value is valid: the
// constructor refuses others. The principal point may be outside the image, because a window of an
// image has the principal point of the whole image.
class CameraIntrinsics {
 public:
  static constexpr int kMaxSize_px = 1 << 16;
  static constexpr double kMaxLength_px = 1e12;  // of focal lengths and principal point

  // 640 x 480 px with a focal length of 680 px and the principal point in the image center.
  constexpr CameraIntrinsics() = default;
  // Throws InputError that names every invalid value.
  constexpr CameraIntrinsics(int width, int height, double fx, double fy, double cx, double cy)
      : width_(width), height_(height), fx_(fx), fy_(fy), cx_(cx), cy_(cy) {
    const bool valid = IsSize(width) && IsSize(height) && IsFocal(fx) && IsFocal(fy) &&
                       IsPosition(cx) && IsPosition(cy);
    if (!valid) ThrowFaults();
  }

  constexpr int width() const { return width_; }
  constexpr int height() const { return height_; }
  constexpr double fx() const { return fx_; }
  constexpr double fy() const { return fy_; }
  constexpr double cx() const { return cx_; }
  constexpr double cy() const { return cy_; }

  // Returns the camera of a window of the image plane. Its pixel (0, 0) is pixel (left, top) of
  // this image. The window may reach outside the image.
  CameraIntrinsics Window(int left, int top, int width, int height) const {
    return {width, height, fx_, fy_, cx_ - left, cy_ - top};
  }

  // Returns one line that names every invalid value with its limits; empty if all are valid. For
  // readers, which add the place of the values.
  static std::string FaultsOf(int width, int height, double fx, double fy, double cx, double cy);

  friend bool operator==(const CameraIntrinsics&, const CameraIntrinsics&) = default;

 private:
  // NaN fails each of these comparisons.
  static constexpr bool IsSize(int size) { return size >= 1 && size <= kMaxSize_px; }
  static constexpr bool IsFocal(double f) { return f > 0 && f <= kMaxLength_px; }
  static constexpr bool IsPosition(double c) { return c >= -kMaxLength_px && c <= kMaxLength_px; }
  [[noreturn]] void ThrowFaults() const;

  int width_ = 640;
  int height_ = 480;
  double fx_ = 680;
  double fy_ = 680;
  double cx_ = 319.5;
  double cy_ = 239.5;
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
  return {k.fx() * p_C.x() / p_C.z() + k.cx(), k.fy() * p_C.y() / p_C.z() + k.cy()};
}

// Returns the point in C (m) that pixel (u, v) shows at depth_m along z.
inline Eigen::Vector3d BackProject(const CameraIntrinsics& k, double u, double v, double depth_m) {
  return {(u - k.cx()) / k.fx() * depth_m, (v - k.cy()) / k.fy() * depth_m, depth_m};
}

}  // namespace pickbed::scenes
