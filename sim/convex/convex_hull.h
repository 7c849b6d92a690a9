#pragma once

// Convex hull of a point set as vertices, faces and edges.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim/layer.h"

namespace pickbed::sim {

// A convex polyhedron.
struct ConvexHull {
  struct Edge {
    int from = 0, to = 0;     // vertex indices
    int left = 0, right = 0;  // faces on its left and right, seen from outside
  };
  std::vector<Eigen::Vector3d> vertices;   // subset of the input points, unchanged
  std::vector<Eigen::Vector3d> normals;    // outward unit normal of each face
  std::vector<Eigen::Vector3i> triangles;  // triangle fans of the faces, outward
  std::vector<Edge> edges;                 // each edge of the faces once
  std::vector<int> triangle_faces;         // face index of each triangle

  // Returns the volume in the cubed unit of the points.
  double Volume() const;
};

// Computes the hull with Bullet's btConvexHullComputer. Returns an empty hull if the points do not
// span a volume (fewer than four, or all in one plane). A point within about 1e-4 of the hull's
// size of a face may count as inside. Throws InputError if a point is not finite.
ConvexHull MakeConvexHull(std::span<const Eigen::Vector3d> points);

}  // namespace pickbed::sim
