#pragma once

// Cuts a mesh by axis-aligned planes into boxes whose contents are nearly convex.

#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct PlaneCutOptions {
  int max_pieces = 16;
  double max_air_share = 0.02;  // of the part's volume that a piece's hull may hold as air
  int uniform_planes = 11;      // candidates per axis, evenly spaced over a piece
  int face_planes = 6;          // more candidates per axis: in the largest flat faces across it
};

// Best first: the piece whose hull holds the most air is cut next, by the plane that makes the sum
// of the two hulls' volumes smallest. Returns the points that span each piece: every vertex of the
// mesh clipped exactly to the piece's box, and the box's corners inside the solid. (Hulls therefore
// miss nothing of the mesh.)
std::vector<std::vector<Eigen::Vector3d>> CutByPlanes(const TriangleMesh& mesh,
                                                      const PlaneCutOptions& options);

}  // namespace pickbed
