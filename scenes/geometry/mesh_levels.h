#pragma once

// Coarser versions of a mesh (levels of detail), each with its deviation from the original surface.

#include <vector>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// One level of detail of a mesh.
struct MeshLevel {
  TriangleMesh mesh;
  // Largest distance between this surface and the original, measured on samples of both.
  double deviation_m = 0;
};

// Returns the original and then levels of increasing deviation. The tolerances go from 0.1 mm to
// 2 % of the bounding box's diagonal in steps of sqrt(2). Each level has at most 3/4 of the
// triangles of the previous one. A mesh with fewer than 64 triangles gets no coarser level.
//
// The normals of a coarser level are computed again; an edge of more than 40 degrees stays sharp.
// The remaining vertices keep their colors and uvs.
std::vector<MeshLevel> MakeMeshLevels(const TriangleMesh& mesh);

// Returns the mesh with fewer triangles, within `tolerance_m` of the original surface. Normals are
// computed as for a level, if the mesh has normals.
TriangleMesh ReducedMesh(const TriangleMesh& mesh, double tolerance_m);

}  // namespace pickbed::scenes
