#pragma once

// Convex pieces as an OBJ file with one "o" group for each.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

// The vertices of each group, scaled to metres; faces are not looked at, a piece is the hull of its
// vertices. Throws InputError naming file and line: unreadable, a vertex that is no three numbers,
// a piece of fewer than four vertices.
std::vector<ConvexPiece> LoadConvexPieces(const std::filesystem::path& path,
                                          const std::string& unit = "m");

}  // namespace pickbed
