#pragma once

// The solid inside a closed mesh as columns along z, for quick volumes of parts of it.

#include <Eigen/Geometry>
#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

class SolidColumns {
 public:
  // `resolution` columns along the longer side of the mesh's footprint.
  SolidColumns(const TriangleMesh& mesh, int resolution);

  // Volume of the solid inside `box`, m^3, good to a few columns' share. An open mesh gives an
  // estimate, and one that is inside out counts as if it were not.
  double VolumeIn(const Eigen::AlignedBox3d& box) const;

 private:
  struct Crossing {
    double z;
    int sign;  // +1 where the column leaves the solid upwards, -1 where it enters
  };
  double low_x_ = 0, low_y_ = 0, cell_ = 0;
  int columns_x_ = 0, columns_y_ = 0;
  double orientation_ = 1;
  std::vector<std::vector<Crossing>> columns_;
};

// Whether a point is inside a closed mesh, by counting crossings of the line through it along z.
bool IsInside(const TriangleMesh& mesh, const Eigen::Vector3d& point);

}  // namespace pickbed
