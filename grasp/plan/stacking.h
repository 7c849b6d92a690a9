#pragma once

// Which instances rest on which, by their poses. An instance under others is wedged and
// carries their weight, so it slips out of the hand more often.

#include <Eigen/Core>
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

 private:
  // The cells around one instance, with the height of its top in each.
  struct TopMap {
    Eigen::Array2i first = Eigen::Array2i::Zero();  // the cell with the smallest indices
    Eigen::Array2i size = Eigen::Array2i::Zero();
    std::vector<double> top_m;  // by row, then column; minus infinity outside the instance

    double Top_m(int x, int y) const {
      return top_m[static_cast<size_t>(y - first.y()) * size.x() + (x - first.x())];
    }
  };
  static int CellsHigher(const TopMap& a, const TopMap& b);

  double cell_m_;
  std::vector<TopMap> maps_;
};

}  // namespace pickbed::grasp
