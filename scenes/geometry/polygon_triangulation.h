#pragma once

// Triangulation of a plane polygon with holes. It uses exactly the given points, so that faces with
// a common outline join without cracks.

#include <Eigen/Core>
#include <vector>

namespace pickbed::scenes {

using Outline = std::vector<Eigen::Vector2d>;  // closed, last point not repeated

double SignedArea(const Outline& outline);  // positive if counter-clockwise

// Triangulates by ear clipping over bridged holes (Eberly, "Triangulation by Ear Clipping", 2002),
// then flips edges towards the constrained Delaunay triangulation (Lawson 1977). Outlines may have
// either winding. Returns counter-clockwise triangles; their indices count the outer points first,
// then the points of each hole in order. Throws std::logic_error when an outline has less than
// three points, when outlines cross themselves or each other, or a hole is outside of `outer`.
std::vector<Eigen::Vector3i> TriangulatePolygon(const Outline& outer,
                                                const std::vector<Outline>& holes = {});

}  // namespace pickbed::scenes
