#pragma once

// Whether parts are in each other or in the bin, judged by their own meshes alone: no convex
// pieces, no separating axes, nothing of sim/.

#include "scenes/scene.h"

namespace pickbed {

struct MeshOverlap {
  double deepest_m = 0;  // of a surface point of one body under the surface of another
  int lost = 0;          // parts whose middle is not over the floor, or whose pose is not finite
};

// `samples` points a part, spread over its surface, beside its corners and points 1 mm apart along
// its sharp edges. A point counts as inside a mesh when rays in two directions both cross its
// surface an odd number of times; it is then as deep as the surface is far. Box bins only.
MeshOverlap MeasureMeshOverlap(const Scene& scene, const ObjectSet& objects, int samples = 2000);

}  // namespace pickbed
