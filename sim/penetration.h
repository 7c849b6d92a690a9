#pragma once

// Whether a scene is physically possible, judged without the physics engine: an own exact
// separating-axis test of convex pieces, so that a wrong contact list cannot hide an overlap.

#include "scenes/scene.h"

namespace pickbed {

// Deepest overlap, m, of any two parts' convex pieces, or of a piece with the bin's floor or walls:
// the shortest translation that would part the two (0 = nothing overlaps). Collision margins are
// not counted. Candidate axes are face normals and cross products of edges, which is complete for
// polyhedra (Gottschalk 1996); edge pairs are pruned by their arcs on the Gauss map (Gregorius
// 2013).
double DeepestPenetration(const Scene& scene, const ObjectSet& objects);

}  // namespace pickbed
