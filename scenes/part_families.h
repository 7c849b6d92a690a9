#pragma once

// Parts made by code: closed meshes, their convex pieces and symmetries from a few dimensions.
// `pickbed_make_parts` writes assets/objects from this table.
//
// Mesh and union of pieces agree to about half a millimetre, bores and cavities included. Screw
// holes of 12 mm and less are the exception: they are filled in the pieces, since resolving one
// costs eight pieces and nothing in a pile reaches into it.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

struct MadePart {
  TriangleMesh mesh_O;  // closed, metres, origin at the middle of its bounding box
  std::vector<ConvexPiece> convex_parts_O;
  SymmetrySet symmetries_O;  // of the shape; a texture may break them
  double density_kgpm3 = 0;
  double friction = 0.5;
};

struct PartRow {
  const char* name;
  const char* help;
  MadePart (*make)();
};

std::span<const PartRow> PartTable();

// Writes folder/{mesh.obj, convex.obj, object.yaml} and the texture, the same bytes on every run.
// Throws InputError when the folder cannot be written.
void WritePart(const PartRow& row, const std::filesystem::path& folder);

}  // namespace pickbed
