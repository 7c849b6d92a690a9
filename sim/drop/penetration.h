#pragma once

// Overlap check of a scene, independent of the physics engine: an exact separating-axis test of
// convex pieces. A wrong contact list of the engine therefore cannot hide an overlap.

#include <vector>

#include "scenes/scene.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Returns the deepest overlap in metres of two instances' convex pieces, or of a piece with the
// bin. This is the shortest translation that separates the two; 0 = no overlap. Collision margins
// are not counted.
// Candidate axes are face normals and cross products of edges, which is complete for polyhedra
// (Gottschalk 1996). Edge pairs are pruned by their arcs on the Gauss map (Gregorius 2013).
double DeepestPenetration(const Scene& scene, const ObjectSet& objects);

// Two bodies of a scene whose convex pieces overlap.
struct Overlap {
  int first = 0;   // index in Scene::objects
  int second = 0;  // index in Scene::objects, or -1 for the bin
};

// Returns the overlaps that are deeper than `limit_m`, each pair once, in ascending order. The
// depth is as in DeepestPenetration().
std::vector<Overlap> OverlapsDeeperThan(double limit_m, const Scene& scene,
                                        const ObjectSet& objects);

}  // namespace pickbed::sim
