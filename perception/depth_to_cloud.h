#pragma once

// Whole-frame work done once: smoothed depth, points and normals of every pixel, and which pixels
// belong to parts rather than to the bin or the table.
//
// A structured-light or time-of-flight camera's axial noise grows with the square of the distance
// (Khoshelham and Elberink 2012), so lengths that guard against noise are stated at 1 m and scaled
// by z^2.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "perception/fitted_background.h"
#include "scenes/bin.h"
#include "scenes/rgbd_frame.h"

namespace pickbed {

struct CloudOptions {
  double background_margin_m = 0.004;  // pixels this near to floor or walls are background, at 1 m
  // Plane fit; odd, 3..15. Parts some 60 px across want 5: a window of 7 averages more noise away
  // but also the narrow faces, and ICP then ends twice as far off.
  int normal_window_px = 5;

  // Only neighbours whose depth is this near to the pixel's take part in its plane fit, at 1 m
  // (scaled by z, as pixels are). Smaller loses steep faces, larger rounds off steps.
  double fit_band_m = 0.010;

  // Used when no background is known: a plane that holds at least this share of all pixels with
  // depth is taken for the table or floor. fitted_background.h tells what is found besides; 1 or
  // more removes nothing (views of a part alone).
  double min_plane_share = 0.25;
};

// Organised like the image; arrays have width * height entries.
struct OrganizedCloud {
  CameraIntrinsics intrinsics;
  Image<Rgb8> color;  // as the frame's, which may have none
  // Holes of single pixels filled, smoothed by the plane fit where there is a normal; 0 = unknown.
  Image<float> depth_m;
  std::vector<Eigen::Vector3f> points_C;   // of depth_m; zero where unknown
  std::vector<Eigen::Vector3f> normals_C;  // unit, towards the camera; zero where unknown or
                                           // unreliable, and on the background
  Image<uint8_t> foreground;               // 1 = has a point and is not background
  std::vector<int> foreground_pixels;      // their indices, ascending
  // Walls and, last, the table or floor, as told or as fitted; empty where neither is known, and
  // for a bin of another shape than the box. Walls end at this height over the floor.
  std::vector<BackgroundPlane> planes;
  float wall_height_m = std::numeric_limits<float>::infinity();
};

// Throws InputError when the frame's depth, or its colour where it has any, is not of the
// intrinsics' size or the options are out of range.
OrganizedCloud BuildCloud(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                          const CloudOptions& options = {});

// Pixels without depth and with depth on at least six of their eight neighbours get the median of
// those.
Image<float> FillSinglePixelHoles(const Image<float>& depth_m);

}  // namespace pickbed
