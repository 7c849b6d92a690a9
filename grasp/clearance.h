#pragma once

// What a hand must stay clear of: the bin's boxes and points of other parts, as observed or
// believed, never the truth.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "grasp/gripper.h"
#include "scenes/bin.h"
#include "scenes/pose.h"

namespace pickbed {

// The volume that the open hand passes through on its straight approach, as boxes in G: those of
// its mechanism (fingers or stem, the palm last), each drawn out backwards by the approach.
std::vector<AxisAlignedBox> HandSweep(const GripperSpec& gripper, double opening_m);

// A box (in G) that comes within `clearance_m` of a bin box, along the axes of W, and which bin
// box: index of BinBoxes. Separating axes of oriented boxes (Gottschalk et al. 1996).
struct BinContact {
  int hand_box = 0;
  int bin_box = 0;
};
std::optional<BinContact> FindBinContact(std::span<const AxisAlignedBox> boxes_G, const Pose& X_WG,
                                         std::span<const AxisAlignedBox> bin_boxes,
                                         double clearance_m);

// True within `band_m` (to a voxel of half of that) of a part's surface points.
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

// Keeps the first point of each voxel, in the box around the bin up to `height_m` above its rim,
// and drops those within `bin_band_m` of floor and walls, which FindBinContact answers for.
std::vector<Eigen::Vector3d> ThinnedCloud(std::span<const Eigen::Vector3d> cloud_W, const Bin& bin,
                                          double voxel_m, double bin_band_m, double height_m);

// Points by columns of the floor plan.
class ObstacleField {
 public:
  // `source` of each point: -1 observed, else the index of the believed pose that it stands for.
  ObstacleField(std::vector<Eigen::Vector3d> points_W, std::vector<int> sources, double cell_m);

  const std::vector<Eigen::Vector3d>& points_W() const { return points_W_; }
  const std::vector<int>& sources() const { return sources_; }

  // Nearest counted point to each hand box, by the largest of its distances to the box's slabs, up
  // to `limit_m`; negative inside. `ignored` holds a flag for each point. `between` counts points
  // in `between_box` (in G), where there is one.
  struct Answer {
    std::vector<double> distance_m;  // by box
    int between = 0;
  };
  Answer Look(const Pose& X_WG, std::span<const AxisAlignedBox> sweep_G,
              const std::optional<AxisAlignedBox>& between_box, const std::vector<uint8_t>& ignored,
              double limit_m) const;

  // Share of the part's floor plan that has a counted point over it.
  double CoveredShare(const Eigen::Matrix3Xd& surface_W, const std::vector<uint8_t>& ignored,
                      double above_m) const;

 private:
  int Column(double x, double y) const;
  Eigen::Vector2d corner_;
  double cell_m_;
  int columns_ = 1, rows_ = 1;
  std::vector<int> begin_;  // by column: first point; one more at the end
  std::vector<Eigen::Vector3d> points_W_;
  std::vector<int> sources_;
};

}  // namespace pickbed
