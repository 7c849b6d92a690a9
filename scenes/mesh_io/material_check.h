#pragma once

// Check of a material file (MTL), which assimp 5.2 does not make.

#include <filesystem>

namespace pickbed::scenes {

// Checks the words and numbers of a material file that belongs to a mesh (Wavefront,
// "Alias/WaveFront Material (.mtl) File Format").
// - Colors have one to three numbers from 0 to 1, and other values have one number.
// - A material begins with newmtl, and names follow newmtl and the maps.
// - Unknown statements of other programs pass, unless they look like a misspelled one.
//
// Throws InputError that names both files and the line.
void CheckMaterialFile(const std::filesystem::path& mesh, const std::filesystem::path& material);

}  // namespace pickbed::scenes
