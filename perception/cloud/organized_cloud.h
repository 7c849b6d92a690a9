#pragma once

// Per-frame preprocessing shared by all estimators: smoothed depth, points, normals, and the
// foreground mask, which separates objects from the bin and the table.
//
// The axial noise of a structured-light or time-of-flight camera grows with the square of the
// distance (Khoshelham and Elberink 2012). Lengths that guard against noise are therefore stated at
// 1 m and scaled by z^2.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "perception/cloud/background_fit.h"
#include "perception/cloud/color_edges.h"
#include "perception/cloud/depth_statistics.h"
#include "scenes/base/settings.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::perception {

struct CloudOptions {
  double background_margin_m = 0.004;  // pixels this near to floor or walls are background, at 1 m
  // Side of the plane-fit window; odd, 3..15. 5 suits objects about 60 px across: a window of 7
  // averages more noise but also the narrow faces, and ICP then ends with twice the error.
  int normal_window_px = 5;

  // Half width of the depth band of neighbours in the plane fit, at 1 m (scaled by z, as pixels
  // are). A smaller band loses steep faces; a larger one rounds off steps.
  double fit_band_m = 0.010;

  // Used without a known background: a plane with at least this share of the points is the table or
  // floor. FitBackground() describes what else is found. At 1, no background is removed (for views
  // of an isolated object).
  double min_plane_share = 0.25;
  void Visit(SettingsVisitor& v);
};

// How the foreground of a cloud was separated. A score has a calibration for each.
enum class BackgroundKind {
  kKnown,   // the background was given
  kFitted,  // planes were found in the image
  kNone,    // no plane was found, or none was looked for
};
inline constexpr int kBackgroundKinds = 3;

// Point cloud with the layout of the image; arrays have width * height entries, row by row.
struct OrganizedCloud {
  CameraIntrinsics intrinsics;
  Image<Rgb8> color;  // color image of the frame; may be empty
  ColorEdges edges;   // of the color image before any binning; may be empty
  // Depth with single-pixel holes filled, smoothed by the plane fit where there is a normal;
  // 0 = unknown.
  Image<float> depth_m;
  std::vector<Eigen::Vector3f> points_C;   // back-projected depth_m; zero where unknown
  std::vector<Eigen::Vector3f> normals_C;  // unit, towards the camera; zero where unknown or
                                           // unreliable, and on the background
  Image<uint8_t> foreground;               // 1 = has a point and is not background
  std::vector<int> foreground_pixels;      // indices of the foreground pixels, ascending
  BackgroundKind background = BackgroundKind::kNone;
  DepthStatistics depth_statistics;  // of depth_m before it was smoothed
  // Factor of lengths that guard against noise, >= 1; see ErrorScale().
  double error_scale = 1;
  // Walls first, then the table or floor, known or fitted. Empty if there is no background and for
  // bins that are not boxes.
  std::vector<BackgroundPlane> planes;
  float wall_height_m = std::numeric_limits<float>::infinity();  // top of the walls over the floor
};

// Preprocesses a frame. With `background` the foreground is what is inside the bin; without it the
// background planes are fitted. Throws InputError for a frame without depth, for a depth or color
// image whose size differs from the intrinsics, and for options out of range.
// With a `region` of the same size, only pixels where it is not 0 are foreground, and background
// planes are fitted to these pixels. The others keep their depth, as evidence against poses. The
// result is the same for any number of threads.
OrganizedCloud BuildCloud(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                          const CloudOptions& options = {}, const Image<uint8_t>* region = nullptr,
                          int threads = 1);

// Returns the depth with single-pixel holes filled: a pixel without depth and with at least six
// valid neighbours of eight gets their lower median. The result is the same for any number of
// threads.
Image<float> FillSinglePixelHoles(const Image<float>& depth_m, int threads = 1);

}  // namespace pickbed::perception
