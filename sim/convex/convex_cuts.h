#pragma once

// Best-first cutting of a mesh by axis-aligned planes into nearly convex pieces.

#include <vector>

#include "scenes/geometry/triangle_mesh.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Options of CutByPlanes().
struct PlaneCutOptions {
  int max_pieces = 16;
  double max_air_share = 0.02;  // allowed air in one hull, as a share of the object's volume
  int uniform_planes = 11;      // candidates per axis, evenly spaced over a piece
  int face_planes = 6;  // more candidates per axis, in the largest flat faces perpendicular to it
};

// Cuts the piece with the most air in its hull, until `max_pieces` or `max_air_share` is reached.
// Each cut uses the plane with the smallest sum of the two hull volumes. Returns the points that
// span each piece: all vertices of the mesh clipped exactly to the piece's box, and the box corners
// inside the solid. The hulls therefore cover the whole mesh. A mesh in a plane, along a line or
// without vertices has no piece. Throws InputError if a vertex is not finite.
std::vector<std::vector<Eigen::Vector3d>> CutByPlanes(const TriangleMesh& mesh,
                                                      const PlaneCutOptions& options);

}  // namespace pickbed::sim
