#pragma once

// Steps that turn the unconnected triangles of a mesh file into an indexed mesh.

#include <array>
#include <cstdint>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Drops triangles with two corners at the same place. Triangles with three collinear corners stay:
// they have no area but close the gap between their neighbours.
void DropDegenerate(TriangleMesh& mesh);

// Drops the normals if all of them equal the face normals. They have no information and would
// prevent joining the vertices of adjacent faces. Also drops the normals if one of them is not of
// unit length, which some exporters write.
void DropFlatNormals(TriangleMesh& mesh);

// Returns whether all normals are of unit length; true if there are none.
bool NormalsAreUnit(const TriangleMesh& mesh);

// Joins vertices that are exactly equal in place, normal, uv and color, in the order in which the
// triangles use them. Unused vertices are dropped. Joining by distance would merge fine detail;
// assimp does so below 10 micrometres.
TriangleMesh WithEqualVerticesJoined(const TriangleMesh& mesh);

// Returns the hashes (MeshHash) that the mesh has without colors and texture: with its normals,
// and without them. Colors split vertices, so the hash of the colored mesh is another one.
std::array<uint64_t, 2> UncoloredHashes(TriangleMesh mesh);

}  // namespace pickbed::scenes
