#pragma once

// Random surroundings of a clutter scene: table, floor, walls, boxes and other things around the
// bin. They train an estimator for images whose background is not known.

#include <span>
#include <vector>

#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Meshes of the surroundings. Planks are flat, with their upper side at z = 0 of their frame.
struct RoomShapes {
  TriangleMesh ground;
  std::vector<TriangleMesh> table_tops;
  std::vector<TriangleMesh> things;
  // Returns all meshes: ground, table tops, things.
  std::vector<const TriangleMesh*> All() const;
};

// Makes the meshes. Boxes, cylinders, hulls and shapes of the shape families have 0.3 to 5 times
// the diameter of one of `objects`. Ground and table tops are for a cell of this size, which is the
// diagonal of the bin floor. The result depends only on the arguments.
RoomShapes MakeRoomShapes(const ObjectSet& objects, double cell_m, uint64_t seed = 0);

// A mesh of RoomShapes::All() with its pose in the frame of the bin.
struct PlacedShape {
  int shape = 0;
  Pose X_BS = Pose::Identity();
};

// A ball that the surroundings do not enter.
struct RoomBall {
  Eigen::Vector3d center_B = Eigen::Vector3d::Zero();
  double radius_m = 0;
};

// Parts of a cell that the surroundings leave free.
struct RoomCell {
  double cell_m = 0.5;   // diagonal of the bin floor
  double support_m = 0;  // height of the surface below the bin in its frame
  Eigen::Vector3d eye_B = Eigen::Vector3d::Zero();  // camera
  std::vector<RoomBall> kept_free;
};

// Places random surroundings. Most rooms have a table or a floor, some have walls, and a few have
// nothing. No shape hides the center of the cell from the camera.
std::vector<PlacedShape> PlaceRoom(const RoomShapes& shapes, const RoomCell& cell, Rng& rng);

}  // namespace pickbed::sim
