#pragma once

// Convex pieces of the solid behind a mesh's surface, for the collisions of a static body.

#include <Eigen/Core>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Returns the vertices (m) of each piece. A connected flat region gives one piece if it is convex,
// else one piece for each triangle. `mesh` must be closed with its faces outwards.
//
// The depth of a piece behind its front is the solid's thickness at each corner. It is at most the
// thickness at the center of the front and at most 50 mm. Pieces under the floor (faces at z = 0
// that point up) are always 50 mm deep.
std::vector<std::vector<Eigen::Vector3d>> SolidPieces(const TriangleMesh& mesh);

}  // namespace pickbed::scenes
