#pragma once

// Check of the values of a PLY file, which assimp 5.2 does not make.

#include <filesystem>

namespace pickbed::scenes {

// Checks that a PLY file has exactly the elements that its header names. In a text file each line
// must have the values that the header names, and integers must fit their types: a uchar is 0 to
// 255. Throws InputError, for a text file with the line. Files that begin with another word pass.
// Call it after CheckMeshFile (scenes/mesh_io/mesh_file_check.h), which checks the header.
void CheckPly(const std::filesystem::path& path);

}  // namespace pickbed::scenes
