#pragma once

// Whole-frame work done once: smoothed depth, points and normals of every pixel, and which pixels
// belong to parts rather than to the bin or the table.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "scenes/bin.h"
#include "scenes/rgbd_frame.h"

namespace pickbed {

struct CloudOptions {
  double background_margin_m = 0.004;  // pixels this near to floor or walls are background, at 1 m
  int normal_window_px = 7;            // plane fit
};

// Organised like the image; arrays have width * height entries.
struct OrganizedCloud {
  CameraIntrinsics intrinsics;
  Image<float> depth_m;                    // holes of single pixels filled; 0 = unknown
  std::vector<Eigen::Vector3f> points_C;   // zero where unknown
  std::vector<Eigen::Vector3f> normals_C;  // unit, towards the camera; zero where unknown
  Image<uint8_t> foreground;               // 1 = has a point and is not background
  std::vector<int> foreground_pixels;      // their indices, ascending
};

OrganizedCloud BuildCloud(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                          const CloudOptions& options = {});

}  // namespace pickbed
