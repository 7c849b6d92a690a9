#pragma once

// Points on the sharp edges of an object, where a camera image usually shows a line.

#include <Eigen/Core>
#include <vector>

#include "perception/layer.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::perception {

// A point on a sharp edge, in O.
struct EdgePoint {
  Eigen::Vector3f p_O;                     // m
  Eigen::Vector3f along_O;                 // unit
  Eigen::Vector3f normal_1_O, normal_2_O;  // unit, of the two faces
};

// Returns evenly spaced points on the edges at which the normals of the faces differ by over 45
// degrees. `max_points` bounds their number; a mesh with more edges gets fewer points per edge.
std::vector<EdgePoint> MakeEdgePoints(const TriangleMesh& mesh, int max_points = 800);

}  // namespace pickbed::perception
