#pragma once

// Writes an object in the format of the catalog, see object_catalog.h.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// The content of a catalog folder.
struct ObjectRecord {
  std::string help;  // one line, written as a comment
  TriangleMesh mesh_O;
  std::vector<ConvexPiece> convex_pieces_O;
  SymmetrySet symmetries_O;
  double density_kgpm3 = 0;  // > 0: mass properties come from the mesh; else `mass` is written
  MassProperties mass;
  double friction = 0.5;
  std::vector<RestingDirection> resting_O;
};

// Writes folder/{mesh.obj, convex.obj, object.yaml} and the texture. The same record gives the same
// bytes. object.yaml is written last, because a folder without it is not an object. Throws
// InputError when the folder cannot be written.
void WriteObject(const ObjectRecord& record, const std::filesystem::path& folder);

}  // namespace pickbed::scenes
