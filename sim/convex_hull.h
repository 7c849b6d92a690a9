#pragma once

// Convex hull of a point set as vertices, faces and edges.

#include <Eigen/Core>
#include <span>
#include <vector>

namespace pickbed {

struct ConvexHull {
  struct Edge {
    int from = 0, to = 0;     // vertices
    int left = 0, right = 0;  // faces seen to the left and right of it from outside
  };
  std::vector<Eigen::Vector3d> vertices;   // some of the input points, as they were given
  std::vector<Eigen::Vector3d> normals;    // of each face, unit, outward
  std::vector<Eigen::Vector3i> triangles;  // the faces cut into fans, outward
  std::vector<Edge> edges;                 // of the faces, each once
  std::vector<int> triangle_faces;         // face of each triangle

  double Volume() const;
};

// Empty when the points do not span a volume (fewer than four, all in one plane). Points within
// about 1e-4 of the hull's size of a face may count as inside it.
ConvexHull MakeConvexHull(std::span<const Eigen::Vector3d> points);

}  // namespace pickbed
