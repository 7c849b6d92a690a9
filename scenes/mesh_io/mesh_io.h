#pragma once

// Reads meshes of any assimp format (OBJ, PLY, STL, DAE, glTF) and writes OBJ.

#include <filesystem>
#include <string>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Returns the metres in one `unit` (m, cm, mm, in). Throws InputError for an unknown unit.
double UnitInMeters(const std::string& unit);

// Maximum number of faces of a loaded mesh. One million faces need 2 GB and more than a minute for
// convex pieces, rendering and the drop.
inline constexpr size_t kMaxMeshFaces = 1000000;

// Data that LoadMesh() removed.
struct MeshLoadReport {
  int degenerate_faces = 0;
  bool bad_normals = false;  // at least one was zero, not a number or not of unit length
};

// Loads all meshes of a file as one, applies node transforms and scales to metres.
// - Triangles with two corners at the same place are dropped. Vertices at the same place are joined
//   if they agree in normal, uv and color.
// - Normals are dropped if they equal the face normals (flat faces) or are not all of unit length.
//   Uvs without a readable texture are dropped. Several textures become vertex colors. A missing
//   texture or .mtl is not an error.
// - Coordinates are read as 32-bit floats (6e-9 m at 0.1 m) and keep the file's own axes: Collada's
//   up_axis and glTF's y-up do not rotate the object. glTF is in metres and Collada's <unit> is
//   applied, so both need unit "m".
// Throws InputError for an unknown unit, a missing or unreadable file, no faces, only faces without
// area, or more faces than kMaxMeshFaces. `report`, if not null, receives what was dropped.
TriangleMesh LoadMesh(const std::filesystem::path& path, const std::string& unit = "m",
                      MeshLoadReport* report = nullptr);

// Writes an OBJ with 10 decimals and the mesh's normals, uvs and vertex colors, if it has them.
// Also writes NAME.mtl for a texture or base color and NAME.png for a texture. The same mesh gives
// the same bytes. Throws InputError when a file cannot be written.
void SaveObj(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace pickbed::scenes
