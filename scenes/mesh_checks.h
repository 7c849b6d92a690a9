#pragma once

// What can be wrong with a mesh.

#include <string>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct MeshReport {
  bool finite = true;
  int triangles = 0;
  int open_edges = 0;     // edges with one (or three...) faces; vertices at equal places are one
  int flipped_edges = 0;  // edges whose two faces disagree about which side is outside
  double volume_m3 = 0;   // signed
  bool watertight() const { return open_edges == 0; }
};

MeshReport InspectMesh(const TriangleMesh& mesh);

// The mesh without faces that another face repeats: the same three places, the same side outside.
// They would count twice in volume and mass.
TriangleMesh WithoutRepeatedFaces(TriangleMesh mesh);

// Throws InputError naming `source` for NaN or infinite vertices, no faces, zero volume (flat
// relative to its bounds). Open and inside-out meshes pass.
void RequireUsableMesh(const TriangleMesh& mesh, const std::string& source);

// The mesh with its faces turned outwards when its signed volume is negative (then also normals
// that look inwards).
TriangleMesh TurnedOutwards(TriangleMesh mesh);

}  // namespace pickbed
