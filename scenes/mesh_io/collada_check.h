#pragma once

// Check of the counts and numbers of a COLLADA file, which assimp 5.2 does not make.

#include <filesystem>

namespace pickbed::scenes {

// Checks that the arrays of a COLLADA file have as many values as they name, that its accessors
// and primitives fit them, that colors and transformations have their numbers, and that the
// geometries of its nodes exist. A file of 16-bit characters passes. Throws InputError with the
// line.
void CheckCollada(const std::filesystem::path& path);

}  // namespace pickbed::scenes
