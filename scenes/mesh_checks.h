#pragma once

// What can be wrong with a mesh.

#include <string>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct MeshReport {
  bool finite = true;
  int triangles = 0;
  int open_edges = 0;    // edges with one face; vertices at equal places count as one
  double volume_m3 = 0;  // signed
  bool watertight() const { return open_edges == 0; }
};

MeshReport InspectMesh(const TriangleMesh& mesh);

// Throws InputError naming `source` for NaN, no faces, zero volume.
void RequireUsableMesh(const TriangleMesh& mesh, const std::string& source);

}  // namespace pickbed
