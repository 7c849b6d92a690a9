#pragma once

// Height maps of an observed surface along the approach of a hand. A cell holds the height against
// the approach: `solid_m` of everything measured or unknown, `seen_m` of measured objects only.
// A hand whose boxes stay above `solid_m` on its straight approach moves through free space only.
//
//          -z of G (height)
//            ^
//            |  __ seen and solid
//            | |  \  solid: border of the shadow
//        ____|_|___\_____> x of G (closing); y of G points into the picture or out of it

#include <Eigen/Core>
#include <vector>

#include "grasp/cloud/observed_surface.h"

namespace pickbed::grasp {

struct HeightMap {
  Eigen::Matrix3d R_BG;        // orientation of the hand in the frame of the bin
  double cell_m = 0.002;       // edge of a cell
  Eigen::Vector2d corner_m{};  // (x, y) of the corner of cell (0, 0), along x and y of G
  int columns = 0, rows = 0;
  std::vector<float> solid_m;  // infinite where the inside of the bin was not seen
  std::vector<float> seen_m;   // -infinite where no object was measured
  std::vector<int> segment;    // of seen_m; kBackground = none

  int Index(int column, int row) const { return row * columns + column; }
  bool Contains(int column, int row) const {
    return column >= 0 && row >= 0 && column < columns && row < rows;
  }
  // Coordinate along x or y of the center of a cell, m.
  double X_m(double column) const { return corner_m.x() + (column + 0.5) * cell_m; }
  double Y_m(double row) const { return corner_m.y() + (row + 0.5) * cell_m; }
  // Returns the point in B with these coordinates along x and y, and this height.
  Eigen::Vector3d PointIn_B(double x_m, double y_m, double height_m) const {
    return R_BG * Eigen::Vector3d(x_m, y_m, -height_m);
  }
};

// Makes the map for one orientation of the hand. Cells without a point take the largest height of
// their neighbors if at least half of these have one. Other cells are solid without limit if they
// are inside the bin at its rim, or if the bin is unknown, and else free. Throws InputError for a
// surface that is wider than 8192 cells.
HeightMap MakeHeightMap(const ObservedSurface& surface, const Eigen::Matrix3d& R_BG, double cell_m,
                        const Bin* bin);

// Returns the maximum over the cells up to `half` columns (or rows) away.
std::vector<float> RunningMaxOfRows(const std::vector<float>& values, int columns, int rows,
                                    int half);
std::vector<float> RunningMaxOfColumns(const std::vector<float>& values, int columns, int rows,
                                       int half);

}  // namespace pickbed::grasp
