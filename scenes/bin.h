#pragma once

// An open box without lid, or any shape from a mesh. Its inner floor is the plane z = 0 of its
// frame B, the origin in the middle of the floor; a bin of zero wall height is a table.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "scenes/bin_shape.h"
#include "scenes/pose.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

struct Bin {
  Eigen::Vector3d inner_size_m{0.40, 0.30, 0.15};  // length x, width y, wall height z
  double wall_m = 0.006;                           // thickness of walls and floor
  double friction = 0.5;                           // own value of the pair rule of friction.h
  // Null = the box above. Physics, its checks and the camera take the shape as it is; the box then
  // says how much room there is, to the planner of grasps and to perception.
  std::shared_ptr<const BinShape> shape = nullptr;

  // Whether a part with its centre of mass here is in the bin.
  bool Holds(const Eigen::Vector3d& p_B) const;
};

// The bin as a cell knows it: its shape and where it stands before the camera.
struct KnownBackground {
  Bin bin;
  Pose X_CB = Pose::Identity();
};

// Floor and four walls of the box as boxes {centre_B, half extents}, axis-aligned in B.
struct AxisAlignedBox {
  Eigen::Vector3d center;
  Eigen::Vector3d half_size;
};
std::vector<AxisAlignedBox> BinBoxes(const Bin& bin);

// Corners of the convex solids that parts collide with: those boxes or the shape's pieces.
std::vector<std::vector<Eigen::Vector3d>> BinPieces(const Bin& bin);

// The bin as one closed mesh (outer and inner faces) for the camera.
TriangleMesh BinMesh(const Bin& bin);

}  // namespace pickbed
