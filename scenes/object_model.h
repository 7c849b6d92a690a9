#pragma once

// A part: what it looks like, weighs and collides with. Immutable once loaded and shared.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "scenes/mass_properties.h"
#include "scenes/symmetry.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

// A convex polyhedron in O; its vertices are those of the hull.
struct ConvexPiece {
  std::vector<Eigen::Vector3d> vertices_O;
};

// A way to lie on a plane and the share of drops that end so, see sim/resting_poses.h.
struct RestingDirection {
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();  // the world's up
  double probability = 0;
};

struct ObjectModel {
  std::string name;
  TriangleMesh mesh_O;  // metres
  MassProperties mass;
  double friction = 0.5;  // against a gripper pad of value 1, see friction.h
  SymmetrySet symmetries_O;
  std::vector<ConvexPiece> convex_parts_O;  // empty until known, see sim/convex_pieces.h
  std::vector<RestingDirection> resting_O;  // most frequent first; empty = not known
  double diameter_m = 0;
  uint64_t mesh_hash = 0;
};

// The parts of a scenario; indices into it name a part everywhere (PosedObject, PoseHypothesis).
using ObjectSet = std::vector<std::shared_ptr<const ObjectModel>>;

}  // namespace pickbed
