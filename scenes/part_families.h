#pragma once

// Parts made by code: closed meshes, their exact convex pieces and symmetries from a few
// dimensions. `pickbed_make_parts` writes assets/objects from this table.

#include <span>
#include <string>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

struct MadePart {
  TriangleMesh mesh_O;  // closed, metres, origin at the middle of its bounding box
  std::vector<ConvexPiece> convex_parts_O;
  SymmetrySet symmetries_O;
  double density_kgpm3 = 0;
  double friction = 0.5;
};

struct PartRow {
  const char* name;
  const char* help;
  MadePart (*make)();
};

std::span<const PartRow> PartTable();

}  // namespace pickbed
