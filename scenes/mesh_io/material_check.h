#pragma once

// Check of a material file (MTL), which assimp 5.2 does not make.

#include <filesystem>
#include <set>

namespace pickbed::scenes {

// Checks the words and numbers of a material file that belongs to a mesh (Wavefront,
// "Alias/WaveFront Material (.mtl) File Format").
// - Colors have one to three numbers from 0 to 1, and other values have one number.
// - A material begins with newmtl, and names follow newmtl and the maps.
// - Unknown statements of other programs pass, unless they look like a misspelled one.
//
// Throws InputError that names both files and the line.
void CheckMaterialFile(const std::filesystem::path& mesh, const std::filesystem::path& material);

// Checks the material files among the files of a mesh. If all of them exist and name materials, an
// OBJ file may use only these, besides the usual names for no material.
//
// Throws InputError that names the mesh, and the line or the material file.
void CheckMaterials(const std::filesystem::path& mesh,
                    const std::set<std::filesystem::path>& files);

}  // namespace pickbed::scenes
