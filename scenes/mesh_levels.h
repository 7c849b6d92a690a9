#pragma once

// Coarser versions of a mesh, each with its deviation from the original surface.

#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct MeshLevel {
  TriangleMesh mesh;
  double deviation_m = 0;  // largest distance between the surfaces, measured on samples both ways
};

// The original first, then levels by rising deviation (tolerances from 0.1 mm up to 2 % of the
// diagonal in steps of sqrt(2)), each with at most 3/4 of the triangles of the one before; the
// original alone when it has few triangles. Normals of a coarser level are made anew, with an edge
// of more than 40 degrees kept sharp; colours and uvs are those of the vertices that stay.
std::vector<MeshLevel> MakeMeshLevels(const TriangleMesh& mesh);

}  // namespace pickbed
