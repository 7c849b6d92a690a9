#pragma once

// Check of the values of a text PLY file, which assimp 5.2 does not make.

#include <filesystem>

namespace pickbed::scenes {

// Checks that each line after the header has the values that the header names, and that integers
// fit their types: a uchar is 0 to 255. Binary files and other formats pass. Throws InputError with
// the line. Call it after CheckMeshFile (scenes/mesh_io/mesh_file_check.h), which checks the
// header.
void CheckPlyText(const std::filesystem::path& path);

}  // namespace pickbed::scenes
