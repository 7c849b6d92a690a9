#pragma once

// Which instances rest on which, and where, by their poses. An instance under others is wedged and
// carries their weight, so it slips out of the hand more often.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "grasp/layer.h"

namespace pickbed::grasp {

// Heights of the instances on the floor plan. One instance is above another if it is the higher one
// in more cells of their common floor plan than it is the lower one.
class InstanceStack {
 public:
  // `cell_m`: size of a cell; it should exceed the spacing of the points.
  explicit InstanceStack(double cell_m) : cell_m_(cell_m) {}

  // Adds an instance with these surface points in W, one per column.
  void Add(const Eigen::Matrix3Xd& surface_W);
  // Returns the indices of the instances above this one, in ascending order.
  std::vector<int> Above(int instance) const;
  // Returns the mean position (x, y) in W of the cells in which other instances rest on this one:
  // their lowest points there are close to its top. Only instances with a true element in `counts`
  // count. None if these cells are fewer than three.
  std::optional<Eigen::Vector2d> CenterOfCover(int instance, const std::vector<bool>& counts) const;

 private:
  // The cells around one instance, with the heights of its highest and lowest point in each.
  struct HeightMap {
    Eigen::Array2i first = Eigen::Array2i::Zero();  // the cell with the smallest indices
    Eigen::Array2i size = Eigen::Array2i::Zero();
    std::vector<double> top_m;     // by row, then column; minus infinity outside the instance
    std::vector<double> bottom_m;  // plus infinity outside the instance

    size_t Index(int x, int y) const {
      return static_cast<size_t>(y - first.y()) * size.x() + (x - first.x());
    }
  };
  // Calls visit(x, y) for each cell of both maps' rectangles.
  template <typename Visit>
  static void ForEachCommonCell(const HeightMap& a, const HeightMap& b, const Visit& visit);
  static int CellsHigher(const HeightMap& a, const HeightMap& b);

  double cell_m_;
  std::vector<HeightMap> maps_;
};

}  // namespace pickbed::grasp
