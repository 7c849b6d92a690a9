#pragma once

// The surface that a depth image shows, as points: what was measured, and the border of what is
// unknown. The space behind the first surface is unknown, and unknown space is not free.
//
//        C            A hand may only move in front of the surface. Between two neighboring
//        |\           pixels with a step in depth, the border of the unknown space runs along
//        | \          the viewing ray. Here it gets points as dense as the measured ones.
//      __|  \ ray
//     |  |   \        measured: ___     border of the unknown space: \ (shadow)
//     |__|____\____

#include <Eigen/Core>
#include <vector>

#include "grasp/layer.h"
#include "grasp/plan/planner.h"
#include "scenes/base/settings.h"

namespace pickbed::grasp {

// SurfacePoint::segment of points that belong to no segment.
inline constexpr int kBackground = -1;  // measured, on the known bin or in a tiny segment
inline constexpr int kShadow = -2;      // border of unknown space

struct SurfacePoint {
  Eigen::Vector3f p_B;  // m, in the frame of the bin
  int segment = kBackground;
};

// A connected piece of measured surface without a step in depth.
struct SurfaceSegment {
  Eigen::Vector3d center_B = Eigen::Vector3d::Zero();  // mean of its points, m
  double top_m = 0;                                    // largest height in B
  int pixels = 0;
};

struct SurfaceOptions {
  double voxel_m = 0.0015;    // edge of the cubes with at most one point
  double step_m = 0.005;      // larger steps between neighboring pixels separate segments
  double bin_band_m = 0.003;  // points this near to floor and walls are background
  int fragment_px = 150;      // smaller segments are joined with a neighbor within fragment_step_m
  double fragment_step_m = 0.015;
  int min_segment_px = 40;  // smaller segments are background
  double margin_m = 0.07;   // points this far beyond the walls are left out
  // A reading with fewer of its eight neighbors within step_m is an outlier and counts as none.
  int min_neighbors = 2;
  void Visit(SettingsVisitor& v);
};

struct ObservedSurface {
  std::vector<SurfacePoint> points;
  std::vector<SurfaceSegment> segments;
};

// Returns the surface of an image. Pixels without a reading get the nearest depth among the
// readings that end their gap in the row and in the column, and become border of unknown space.
// `bin` may be unknown; then nothing is background. Throws InputError for a frame without depth.
ObservedSurface ObserveSurface(const RgbdFrame& frame, const Pose& X_WC,
                               const std::optional<BinPlacement>& bin,
                               const SurfaceOptions& options = {});

}  // namespace pickbed::grasp
