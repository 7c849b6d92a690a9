#pragma once

// Disk cache of the meshes of sampled shapes. A mesh takes 0.03 to 1 s, and a read takes
// milliseconds.

#include "scenes/geometry/triangle_mesh.h"
#include "scenes/shape_families/solid_shape.h"

namespace pickbed::scenes {

// Returns MeshOfSolid() with its default options, from the cache of an earlier call if possible.
// The key is the content of the solid. A damaged file of the cache is replaced.
TriangleMesh CachedMeshOfSolid(const SolidShape& solid);

}  // namespace pickbed::scenes
