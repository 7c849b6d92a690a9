#pragma once

// Signs of a solid on a regular grid, and the crossings of its edges with the surface.

#include <Eigen/Core>
#include <vector>

#include "scenes/shape_families/solid_shape.h"

namespace pickbed::scenes {

// A point of the surface on a grid edge.
struct GridCrossing {
  int corner = 0;       // index of the grid point at the lower end of the edge
  int axis = 0;         // direction of the edge
  bool leaves = false;  // the lower end is inside
  Eigen::Vector3f point = Eigen::Vector3f::Zero();   // m
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, outwards
};

// Grid points around the solid's box. The outermost points are outside the solid.
struct SolidGrid {
  float cell_m = 0;
  Eigen::Vector3f origin_O = Eigen::Vector3f::Zero();  // of point (0, 0, 0), m
  Eigen::Vector3i size = Eigen::Vector3i::Zero();      // number of points along each axis
  std::vector<unsigned char> inside;                   // of each point, x fastest
  std::vector<GridCrossing> crossings;                 // sorted by axis, then by corner

  int Index(int x, int y, int z) const { return x + size.x() * (y + size.y() * z); }
  int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? size.x() : size.x() * size.y(); }
  Eigen::Vector3i Cell(int index) const;
  Eigen::Vector3f Point(int index) const;  // m
};

// Samples the solid. Blocks of the grid that are farther from the surface than their size are not
// evaluated point by point.
SolidGrid SampleGrid(const SolidShape& solid, float cell_m);

}  // namespace pickbed::scenes
