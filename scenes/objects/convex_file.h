#pragma once

// Reads convex pieces from an OBJ file with one "o" group for each piece.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// Returns the vertices of each group, scaled to metres. Faces are ignored, because a piece is the
// convex hull of its vertices. Throws InputError with file and line for an unreadable file, a
// vertex that is not three numbers or is before the first group, and a piece with fewer than four
// vertices or with all of them in one plane.
std::vector<ConvexPiece> LoadConvexPieces(const std::filesystem::path& path,
                                          const std::string& unit = "m");

}  // namespace pickbed::scenes
