#pragma once

// Reads convex pieces from an OBJ file with one "o" group for each piece.

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// Returns the vertices of each group, scaled to metres. Faces are checked but not used, because a
// piece is the convex hull of its vertices. Throws InputError with file and line for an unreadable
// file, a vertex that is not three numbers or is before the first group, a damaged line, a face
// with a vertex that the file does not have, and a piece with fewer than four vertices or with all
// of them in one plane.
std::vector<ConvexPiece> LoadConvexPieces(const std::filesystem::path& path,
                                          const std::string& unit = "m");

// Returns whether the points are not all near one plane: their thickness is over 2e-4 of their
// length. The hull of a thinner piece may have no volume, see sim/convex/convex_hull.h.
bool SpansAVolume(std::span<const Eigen::Vector3d> points);

}  // namespace pickbed::scenes
