#pragma once

// Shapes of unknown objects, for planners without object models. A shape is a grid of occupancy
// probabilities around one object. Its source is outside of this folder: a completion of the
// observed surface, or the ground truth.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "grasp/completed/grasped_segment.h"
#include "grasp/plan/planner.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::grasp {

// Probabilities at which a shape is grasped, and from which a hand keeps out of it.
inline constexpr double kSurfaceLevel = 0.45;
inline constexpr double kPossibleLevel = 0.3;

// Occupancy of a cube around one object. Frame V has its origin at the corner of cell (0, 0, 0),
// and its axes along the edges of the cube.
struct OccupancyShape {
  Pose X_WV = Pose::Identity();
  double cell_m = 0;             // edge of a cell
  int size = 0;                  // cells along each axis
  std::vector<float> occupancy;  // probability that the cell is inside, size^3 values, x fastest

  // Returns the probability of a cell; 0 outside the cube.
  float At(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= size || y >= size || z >= size) return 0;
    return occupancy[(static_cast<size_t>(z) * size + y) * size + x];
  }
  Eigen::Vector3d Center_V(int x, int y, int z) const {
    return cell_m * (Eigen::Vector3d(x, y, z).array() + 0.5).matrix();
  }
};

// Gives the shapes of the objects in an image.
class ShapeSource {
 public:
  virtual ~ShapeSource() = default;
  // Returns the shapes of the highest objects in the image, highest first, at most `max_shapes`.
  virtual std::vector<OccupancyShape> Shapes(const PlannerInput& input, int max_shapes) = 0;
  // Returns the segments of the image of the last call of Shapes(). Default: none.
  virtual ImageSegments Segments() const { return {}; }
};

// Returns the shape smoothed by a binomial filter of three cells along each axis, which has a
// standard deviation of 0.7 cells. Normals from its gradient are less noisy.
OccupancyShape Smoothed(const OccupancyShape& shape);

// Returns the closed surface of the cells with at least `level` in V (naive surface nets: Gibson,
// "Constrained elastic surface nets", MICCAI 1998). Triangles face away from the inside. The mesh
// is empty if no cell reaches the level. `level` is 0..1, exclusive.
TriangleMesh SurfaceOf(const OccupancyShape& shape, double level);

// Returns the centers in W of the cells with more than `level` that have a neighbour with less.
std::vector<Eigen::Vector3d> ShellOf(const OccupancyShape& shape, double level);

}  // namespace pickbed::grasp
