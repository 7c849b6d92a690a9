#pragma once

// Meshes of any assimp format (OBJ, PLY, STL, DAE, glTF) in, OBJ out.

#include <filesystem>
#include <string>

#include "scenes/triangle_mesh.h"

namespace pickbed {

// Metres in one `unit` (m, cm, mm, in). Throws InputError for another word.
double UnitInMeters(const std::string& unit);

// All meshes of the file as one, node transforms applied, scaled to metres, degenerate triangles
// dropped, equal vertices joined when they agree in normal and uv. A missing texture or .mtl is not
// an error. Throws InputError: missing, unreadable, no faces.
TriangleMesh LoadMesh(const std::filesystem::path& path, const std::string& unit = "m");

// OBJ with normals, and with uvs, an .mtl and a PNG beside it when the mesh has a texture.
void SaveObj(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace pickbed
