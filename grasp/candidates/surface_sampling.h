#pragma once

// Points along the sharp edges of an object. Points sampled by area leave gaps of up to their
// spacing at rims and corners, where a hand makes contact first.

#include <Eigen/Core>

#include "grasp/layer.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::grasp {

// Samples the sharp edges of a mesh. Every position on a sharp edge has a point within `spacing_m`.
// An edge is sharp if its faces differ by more than `turn_rad`, or if it has only one face.
// Vertices at the same position count as one. Returns one point per column.
Eigen::Matrix3Xd SharpEdgePoints(const TriangleMesh& mesh, double spacing_m, double turn_rad = 0.6);

}  // namespace pickbed::grasp
