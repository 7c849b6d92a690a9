#pragma once

// An object model: surface, mass, friction, symmetries and collision shape. It is shared and does
// not change after loading.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/symmetry.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// A pose is correct when its MSSD is below this share of the object's diameter, the usual threshold
// of the field.
inline constexpr double kCorrectDiameters = 0.1;

// A convex polyhedron in O: the convex hull of its vertices.
struct ConvexPiece {
  std::vector<Eigen::Vector3d> vertices_O;  // m
};

// A stable orientation on a plane, see sim/drop/resting_poses.h.
struct RestingDirection {
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  // the world's up direction in O
  double probability = 0;                           // share of drops that end in this orientation
};

// Model of one object in its frame O.
struct ObjectModel {
  std::string name;
  TriangleMesh mesh_O;  // metres
  MassProperties mass;
  double friction = 0.5;  // against a gripper pad of value 1, see contact.h
  SymmetrySet symmetries_O;
  std::vector<ConvexPiece> convex_pieces_O;  // empty = unknown, see sim/convex/convex_pieces.h
  std::vector<RestingDirection> resting_O;   // most frequent first; empty = unknown
  double diameter_m = 0;
  uint64_t mesh_hash = 0;
};

// The objects of a scenario. An `object` index refers to this list everywhere (PosedObject,
// PoseHypothesis).
using ObjectSet = std::vector<std::shared_ptr<const ObjectModel>>;

}  // namespace pickbed::scenes
