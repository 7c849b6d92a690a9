#pragma once

// Checks of a mesh and repairs that keep its shape.

#include <string>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Result of InspectMesh(). If a vertex is not finite, only `finite` and `triangles` are valid.
struct MeshReport {
  bool finite = true;
  int triangles = 0;
  int open_edges = 0;     // edges without exactly two faces; vertices at the same place are one
  int flipped_edges = 0;  // edges whose two faces disagree about which side is outside
  double volume_m3 = 0;   // signed, negative if the faces point inwards
  bool watertight() const { return open_edges == 0; }
};

// Counts open and flipped edges and computes the signed volume.
MeshReport InspectMesh(const TriangleMesh& mesh);

// Removes faces that repeat another face: the same three places and the same side outside. They
// would count twice in volume and mass.
TriangleMesh WithoutRepeatedFaces(TriangleMesh mesh);

// Throws InputError, naming `source`, for NaN or infinite vertices, no faces or zero volume (flat
// relative to its bounds). Open and inside-out meshes pass.
void RequireUsableMesh(const TriangleMesh& mesh, const std::string& source);

// Reverses faces so that neighbours agree about the outside. In each group of connected faces, the
// side with the larger area wins; groups without a contradiction stay as they are. If a face is
// reversed, the normals are dropped. Faces of a surface with one side (a Moebius strip) keep some
// contradictions.
TriangleMesh WithAgreeingFaces(TriangleMesh mesh);

// Reverses all faces if the signed volume is negative. The normals are then also reversed if they
// point inwards.
TriangleMesh TurnedOutwards(TriangleMesh mesh);

}  // namespace pickbed::scenes
