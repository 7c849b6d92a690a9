#pragma once

// Check of the text of a glTF file. assimp 5.2 leaves out what it does not understand.

#include <filesystem>

namespace pickbed::scenes {

// Checks the text of a glTF file, or of the first part of a GLB file: that it is JSON without
// repeated or misspelled keys, that indices and counts are whole numbers, and that transformations
// and colors have their numbers. Extensions and files of version 1 have keys of their own, and
// pass. Throws InputError with the place, such as nodes/0/matrix.
void CheckGltf(const std::filesystem::path& path);

}  // namespace pickbed::scenes
