#pragma once

// Overlap of instances with each other and with the bin. It uses only the meshes: no convex pieces,
// no separating axes, nothing from sim/.

#include "scenes/scene.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

struct MeshOverlap {
  double deepest_m = 0;  // of a surface point of one body below the surface of another
  int lost = 0;  // instances whose center is not above the floor, or whose pose is not finite
};

// Measures with `samples` random points on the surface of each object, its vertices, and points 1
// mm apart on its sharp edges. A point is inside a mesh if rays in two directions both cross the
// surface an odd number of times; its depth is the distance to the surface. Only for box bins.
MeshOverlap MeasureMeshOverlap(const Scene& scene, const ObjectSet& objects, int samples = 2000);

}  // namespace pickbed::tests
