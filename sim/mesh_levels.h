#pragma once

// Coarser versions of a mesh, each with the deviation from the original surface that it costs.

#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct MeshLevel {
  TriangleMesh mesh;
  double deviation_m = 0;
};

// The original first, then levels by rising deviation, as long as they save triangles.
std::vector<MeshLevel> MakeMeshLevels(const TriangleMesh& mesh);

}  // namespace pickbed
