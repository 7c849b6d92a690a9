#pragma once

// Triangulation of a flat polygon with holes that uses exactly the given points, so that faces
// which share an outline close without cracks.

#include <Eigen/Core>
#include <vector>

namespace pickbed {

using Outline = std::vector<Eigen::Vector2d>;  // closed, last point not repeated

double SignedArea(const Outline& outline);  // > 0: counter-clockwise

// Ear clipping over bridged holes (Eberly, "Triangulation by Ear Clipping", 2002), then edge flips
// towards the constrained Delaunay triangulation (Lawson 1977). Either winding is taken; triangles
// come out counter-clockwise. Indices count the outer points first, then those of each hole in
// turn. Throws std::logic_error when outlines cross themselves or each other.
std::vector<Eigen::Vector3i> TriangulatePolygon(const Outline& outer,
                                                const std::vector<Outline>& holes = {});

}  // namespace pickbed
