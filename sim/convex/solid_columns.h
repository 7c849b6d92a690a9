#pragma once

// A closed mesh's solid as columns along z, for fast volumes of box-shaped regions of it.

#include <Eigen/Geometry>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Crossings of a closed mesh's surface with a grid of lines along z.
class SolidColumns {
 public:
  // Divides the longer side of the mesh's footprint into `resolution` columns.
  SolidColumns(const TriangleMesh& mesh, int resolution);

  // Returns the volume of the solid inside `box`, in m^3, with an error of a few columns. An open
  // mesh gives an estimate. A mesh with inverted orientation gives a positive volume too.
  double VolumeIn(const Eigen::AlignedBox3d& box) const;

 private:
  struct Crossing {
    double z_m;
    int sign;  // +1 where the column leaves the solid upwards, -1 where it enters
  };
  double low_x_m_ = 0, low_y_m_ = 0, cell_m_ = 0;
  int columns_x_ = 0, columns_y_ = 0;
  double orientation_ = 1;
  std::vector<std::vector<Crossing>> columns_;
};

// Returns whether a point is inside a closed mesh, by the number of surface crossings above it
// along z.
bool IsInside(const TriangleMesh& mesh, const Eigen::Vector3d& point);

}  // namespace pickbed::sim
