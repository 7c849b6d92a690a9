#pragma once

// Objects made by code: closed meshes, convex pieces and symmetries from a few dimensions.
// `pickbed_make_parts` writes assets/objects from this table.
//
// The mesh and the union of its pieces agree to about half a millimetre, including bores and
// cavities. Screw holes of 12 mm and less are an exception: they are filled in the pieces. One hole
// would need eight more pieces, and nothing in a clutter scene reaches into it.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// An object made by code.
struct FamilyObject {
  TriangleMesh mesh_O;  // closed, metres, origin at the center of its bounding box
  std::vector<ConvexPiece> convex_pieces_O;
  SymmetrySet symmetries_O;  // of the shape; a texture may not have them
  double density_kgpm3 = 0;
  double friction = 0.5;
};

// A row of the table: name, one line of help and the function that makes the object.
struct FamilyRow {
  const char* name;
  const char* help;
  FamilyObject (*make)();
};

// Returns all objects that are made by code.
std::span<const FamilyRow> FamilyTable();

// Writes folder/{mesh.obj, convex.obj, object.yaml} and the texture, with the same bytes on every
// run. Throws InputError when the folder cannot be written.
void WriteFamilyObject(const FamilyRow& row, const std::filesystem::path& folder);

}  // namespace pickbed::scenes
