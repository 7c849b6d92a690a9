#pragma once

// Points along the sharp edges of a part. Points spread over its surface by area leave its rims and
// corners unguarded by up to their spacing, and rims are what a hand meets first.

#include <Eigen/Core>

#include "scenes/triangle_mesh.h"

namespace pickbed {

// 3 x n: every place on an edge whose faces turn by more than `turn_rad` has one of these points
// within `spacing_m`. An edge with one face is sharp. Vertices at the same place are one vertex.
Eigen::Matrix3Xd SharpEdgePoints(const TriangleMesh& mesh, double spacing_m, double turn_rad = 0.6);

}  // namespace pickbed
