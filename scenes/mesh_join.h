#pragma once

// From the loose corners of a mesh file to an indexed mesh.

#include "scenes/triangle_mesh.h"

namespace pickbed {

// Drops the triangles with two corners at one place. Slivers with three corners in a row stay: they
// have no area but close the gap between their neighbours.
void DropDegenerate(TriangleMesh& mesh);

// Drops the normals when all of them are the normals of the faces: they say nothing and would keep
// the corners of neighbouring faces apart. Also when one is not unit, as some exporters write.
void DropFlatNormals(TriangleMesh& mesh);

// Whether all normals are of unit length; true for none.
bool NormalsAreUnit(const TriangleMesh& mesh);

// Joins vertices that agree exactly in place, normal, uv and colour, in the order in which the
// triangles name them; drops those that none names. (Importers that join by nearness pull fine
// detail together: assimp does so below 10 micrometres.)
TriangleMesh WithEqualVerticesJoined(const TriangleMesh& mesh);

}  // namespace pickbed
