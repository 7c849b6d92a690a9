#pragma once

// Edges of a mesh with the normals of both faces, for outlines and sharp edges.

#include <Eigen/Core>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// An edge between two faces, in the frame of the mesh. An edge of one face has its opposite as the
// second normal, so that it is sharp.
struct MeshEdge {
  Eigen::Vector3d a, b;                // ends, m
  Eigen::Vector3d normal_1, normal_2;  // unit
  double normal_cos() const { return normal_1.dot(normal_2); }
};

// Returns all edges. Vertices at one place are one vertex. Faces without area have
// no edges. An edge of more than two faces has the normals of the first and the last.
std::vector<MeshEdge> MeshEdges(const TriangleMesh& mesh);

}  // namespace pickbed::scenes
