#pragma once

// Checks of the words of text meshes, which assimp 5.2 does not make.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace pickbed::scenes {

// Limit of a texture coordinate, in sizes of the texture. A float over it has no place within the
// texture.
inline constexpr double kMaxTextureCoordinate = 1 << 23;

// Checks a mesh by its extension: as the next two functions, CheckPly()
// (scenes/mesh_io/ply_check.h), CheckCollada() (scenes/mesh_io/collada_check.h) or CheckGltf()
// (scenes/mesh_io/gltf_check.h). Other formats pass.
void CheckMeshText(const std::filesystem::path& path);

// Checks the numbers of an OBJ: places, normals, texture coordinates and corners of faces. Unknown
// statements pass, since programs have their own ones, but only if they begin with a word. Throws
// InputError with the line.
void CheckObjText(const std::filesystem::path& path);

// Returns the fault of a line of an OBJ as the rest of a sentence: "has 2 numbers after 'v'".
// Empty: there is none. `words`: of the line without its comment.
std::string FaultOfObjLine(std::span<const std::string_view> words);

// Checks all words of a text STL. A binary file passes unread. Throws InputError with the facet.
void CheckStlText(const std::filesystem::path& path);

}  // namespace pickbed::scenes
