#pragma once

// Obstacles of a hand: the boxes of the bin, and points on other instances. The points are observed
// or come from estimated poses, never from the ground truth.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "grasp/gripper.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"

namespace pickbed::grasp {

// Volume that the open hand sweeps on its straight approach, as boxes in G: the boxes of its
// hand (fingers or stem, the palm last), each extended backwards by `approach_m`.
std::vector<AxisAlignedBox> HandSweep(const Gripper& gripper, double opening_m);

// Two boxes that collide.
struct BinContact {
  int hand_box = 0;  // index of the box of the hand
  int bin_box = 0;   // index of the box of the bin
};
// Returns the first collision of the boxes of a hand (in G) with the boxes of a bin (BinBoxes()),
// or nullopt. The order is by boxes of the bin, then of the hand. The boxes of the bin are grown by
// `clearance_m` along the axes of W. Uses separating axes of oriented boxes (Gottschalk et al.
// 1996).
std::optional<BinContact> FindBinContact(std::span<const AxisAlignedBox> boxes_G, const Pose& X_WG,
                                         std::span<const AxisAlignedBox> bin_boxes,
                                         double clearance_m);

// Returns whether a hand meets the bin on its straight approach or when it closes. The sweep keeps
// `clearance_m` from the boxes of the bin. Fingers on both sides of a wall close on the wall, not
// on an object, so the region between them must not meet the bin either.
bool HandMeetsBin(const Gripper& gripper, double opening_m, const Pose& X_WG,
                  std::span<const AxisAlignedBox> bin_boxes, double clearance_m);

// Returns whether one of the points is inside of one of the boxes, all in G.
bool AnyInside(const Eigen::Matrix3Xd& points_G, std::span<const AxisAlignedBox> boxes_G);

// Set of the points within `band_m` of the surface points of an object, at a resolution of half of
// `band_m`.
class SurfaceBand {
 public:
  SurfaceBand(const Eigen::Matrix3Xd& points_O, double band_m);
  bool Contains(const Eigen::Vector3d& p_O) const;

 private:
  int Index(const Eigen::Vector3i& cell) const;
  Eigen::Vector3d corner_;
  Eigen::Vector3i size_;
  double voxel_m_;
  std::vector<uint8_t> inside_;
};

// Voxel filter that keeps the first point of each voxel. It only keeps points in the box around the
// bin, up to `height_m` above its rim. It drops points within `bin_band_m` of floor and walls,
// because FindBinContact checks those.
std::vector<Eigen::Vector3d> ThinnedCloud(std::span<const Eigen::Vector3d> cloud_W, const Bin& bin,
                                          double voxel_m, double bin_band_m, double height_m);

// Obstacle points, sorted into a grid of square cells (columns) on the floor plan. The points of a
// column are sorted from the top down, so that a query visits no point below a box.
class ObstacleField {
 public:
  // `groups`: number from 0 of the group of each point. The points of a group, such as the ones of
  // an estimated pose, are ignored together.
  ObstacleField(std::vector<Eigen::Vector3d> points_W, std::vector<int> groups, double cell_m);

  const std::vector<Eigen::Vector3d>& points_W() const { return points_W_; }
  const std::vector<int>& groups() const { return groups_; }

  // Distance of the nearest point to each hand box (in G) at X_WG, up to `limit_m`. The distance is
  // the largest of the distances to the slabs of the box; it is negative inside. `ignored` has one
  // flag per group. `between` counts points in `between_box` (in G), if there is one.
  struct Answer {
    std::vector<double> distance_m;  // by box
    int between = 0;
  };
  Answer Query(const Pose& X_WG, std::span<const AxisAlignedBox> sweep_G,
               const std::optional<AxisAlignedBox>& between_box,
               const std::vector<uint8_t>& ignored, double limit_m) const;

  // First of the hand boxes with a point nearer than `clearance_m`, which may be negative; nullopt
  // if there is none. Distances as in Query(). It is much faster than Query().
  std::optional<int> FirstMet(const Pose& X_WG, std::span<const AxisAlignedBox> sweep_G,
                              const std::vector<uint8_t>& ignored, double clearance_m) const;

  // Share of the floor plan of `surface_W` with a point that is not ignored and more than `above_m`
  // above the surface.
  double CoveredShare(const Eigen::Matrix3Xd& surface_W, const std::vector<uint8_t>& ignored,
                      double above_m) const;

 private:
  int Column(double x, double y) const;
  // Calls `visit(p_G)` for each point that is not ignored and near the box, grown by `margin_m`.
  // Ends early and returns true if `visit` returns true.
  template <typename Visit>
  bool AnyNear(const Pose& X_WG, const AxisAlignedBox& box_G, double margin_m,
               const std::vector<uint8_t>& ignored, const Visit& visit) const;
  Eigen::Vector2d corner_;
  double cell_m_;
  int columns_ = 1, rows_ = 1;
  std::vector<int> begin_;  // first point of each column, and the total at the end
  std::vector<Eigen::Vector3d> points_W_;
  std::vector<int> groups_;
};

}  // namespace pickbed::grasp
