#pragma once

// Writes a part as the catalog reads it, see object_catalog.h.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

struct ObjectRecord {
  std::string help;  // one line
  TriangleMesh mesh_O;
  std::vector<ConvexPiece> convex_parts_O;
  SymmetrySet symmetries_O;
  double density_kgpm3 = 0;  // > 0: mass properties follow from the mesh; else `mass` is written
  MassProperties mass;
  double friction = 0.5;
  std::vector<RestingDirection> resting_O;
};

// Writes folder/{mesh.obj, convex.obj, object.yaml} and the texture, the same bytes for the same
// record; object.yaml last, so that a folder without it is no part. Throws InputError when the
// folder cannot be written.
void WriteObject(const ObjectRecord& record, const std::filesystem::path& folder);

}  // namespace pickbed
