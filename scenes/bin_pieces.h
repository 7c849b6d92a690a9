#pragma once

// The solid behind a mesh's surface as convex pieces, for a static body.

#include <Eigen/Core>
#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

// Corners of each piece. A connected flat region that is convex makes one piece, any other one a
// piece a triangle; behind its front it goes as deep as the solid does at each corner and at most
// as in the middle, 50 mm at most. Under the floor, faces that look up at z = 0, it is 50 mm deep
// in any case. The mesh is closed with faces outwards.
std::vector<std::vector<Eigen::Vector3d>> SolidPieces(const TriangleMesh& mesh);

}  // namespace pickbed
