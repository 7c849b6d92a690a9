#pragma once

// Meshes of any assimp format (OBJ, PLY, STL, DAE, glTF) in, OBJ out.

#include <filesystem>
#include <string>

#include "scenes/triangle_mesh.h"

namespace pickbed {

// Metres in one `unit` (m, cm, mm, in). Throws InputError for another word.
double UnitInMeters(const std::string& unit);

// What is loaded at most: cut, drawn and dropped, a million faces take 2 GB and more than a minute.
inline constexpr size_t kMostFaces = 1000000;

// All meshes of the file as one, node transforms applied, scaled to metres, triangles with two
// corners at one place dropped, equal vertices joined when they agree in normal, uv and colour.
// Normals that are those of the faces are dropped (flat faces), uvs without a readable texture too;
// several textures become vertex colours. A missing texture or .mtl is not an error.
// Coordinates pass through 32-bit floats (6e-9 m at 0.1 m) and keep the file's own axes: neither
// Collada's up_axis nor glTF's y-up turns the part. glTF is in metres and Collada's <unit> is
// applied, so that both want unit "m".
// Throws InputError: unknown unit, missing, unreadable, no faces, more faces than kMostFaces.
// `report`, when given, says what was dropped on the way.
struct MeshLoadReport {
  int degenerate_faces = 0;
  bool bad_normals = false;  // one at least was zero, not a number or not of unit length
};
TriangleMesh LoadMesh(const std::filesystem::path& path, const std::string& unit = "m",
                      MeshLoadReport* report = nullptr);

// OBJ with normals, uvs and vertex colours as far as the mesh has them, 10 decimals, the same bytes
// for the same mesh; beside it NAME.mtl for a texture or base colour and NAME.png for a texture.
// Throws InputError when a file cannot be written.
void SaveObj(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace pickbed
