#pragma once

// Intrinsics of a camera in the files of usual programs.

#include <optional>
#include <string>

#include "eval/layer.h"
#include "scenes/camera/camera.h"

namespace pickbed::eval {

// Intrinsics as they were given.
struct GivenIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  int width = 0, height = 0;              // px; 0 = not given
  std::optional<double> depth_scale_mm;   // mm per unit of the depth image, if the file has it
  bool is_distorted = false;              // the file has distortion coefficients that are not zero

  // Returns the intrinsics of an image of this size. Throws InputError that begins with `name` if
  // the image has another size than the given one, or if the principal point is outside the image.
  CameraIntrinsics ForImage(int width_px, int height_px, const std::string& name) const;
};

// Reads intrinsics from "FX,FY,CX,CY" or from a file:
// - BOP's camera.json: fx, fy, cx, cy, width, height, depth_scale
// - an entry of BOP's scene_camera.json: cam_K, depth_scale
// - camera_info of ROS as YAML: image_width, camera_matrix or K, distortion_coefficients or D
// - Open3D's JSON: width, height, intrinsic_matrix (by columns)
// - RealSense's names: fx, fy, ppx, ppy, coeffs
// - a text file of nine numbers: the camera matrix by rows
// Throws InputError with the file and the reason.
GivenIntrinsics ReadIntrinsics(const std::string& text_or_file);

}  // namespace pickbed::eval
