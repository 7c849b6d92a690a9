#pragma once

// Checks of the words of text meshes, which assimp 5.2 does not make.

#include <filesystem>

namespace pickbed::scenes {

// Checks a mesh by its extension: as the next two functions, CheckPly()
// (scenes/mesh_io/ply_check.h) or CheckCollada() (scenes/mesh_io/collada_check.h). Other formats
// pass.
void CheckMeshText(const std::filesystem::path& path);

// Checks the numbers of an OBJ: places, normals, texture coordinates and corners of faces. Unknown
// statements pass, since programs have their own ones, but only if they begin with a word. Throws
// InputError with the line.
void CheckObjText(const std::filesystem::path& path);

// Checks all words of a text STL. A binary file passes unread. Throws InputError with the facet.
void CheckStlText(const std::filesystem::path& path);

}  // namespace pickbed::scenes
