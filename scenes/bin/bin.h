#pragma once

// A bin: an open box without lid, or any shape from a mesh. The inner floor is the plane z = 0 of
// the bin's frame B, with the origin in the center of the floor. A bin of zero wall height is a
// table.
//
//        |     z     |
//        |     |     |   walls; y points into the picture
//        |     B--x  |
//        +-----------+   inner floor: z = 0

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "scenes/bin/bin_shape.h"
#include "scenes/geometry/pose.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Dimensions and friction of a bin; plain data.
struct Bin {
  Eigen::Vector3d inner_size_m{0.40, 0.30, 0.15};  // length x, width y, wall height z
  double wall_m = 0.006;                           // thickness of walls and floor
  double friction = 0.5;                           // the bin's factor in PairFriction()
  // Null = the box above. Physics, its checks and the camera use the exact shape. The grasp planner
  // and perception then use the box above as the available space.
  std::shared_ptr<const BinShape> shape = nullptr;

  // Returns whether an instance with its center of mass at p_B (m) is in the bin.
  bool Holds(const Eigen::Vector3d& p_B) const;
};

// The known background of an image: the bin and its pose in the camera frame.
struct KnownBackground {
  Bin bin;
  Pose X_CB = Pose::Identity();
};

// A box with its axes along B.
struct AxisAlignedBox {
  Eigen::Vector3d center;     // m, in B
  Eigen::Vector3d half_size;  // m
};
// Returns the floor and the four walls of the box. A bin without walls has only the floor.
std::vector<AxisAlignedBox> BinBoxes(const Bin& bin);

// Returns the vertices (m, in B) of the convex solids for collisions: the boxes of BinBoxes() or
// the pieces of the shape.
std::vector<std::vector<Eigen::Vector3d>> BinPieces(const Bin& bin);

// Returns the bin as one closed mesh in B with outer and inner faces, for the camera.
TriangleMesh BinMesh(const Bin& bin);

}  // namespace pickbed::scenes
