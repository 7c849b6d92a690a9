#pragma once

// The surface of a solid as a closed triangle mesh.
//
// The surface is sampled where it crosses the edges of a grid, and each cell gets one vertex for
// each sheet of the surface in it. The vertex minimizes the distance to the tangent planes at the
// crossings, which keeps sharp edges (Ju et al., "Dual Contouring of Hermite Data", SIGGRAPH 2002;
// Nielson, "Dual Marching Cubes", IEEE Visualization 2004).

#include "scenes/geometry/triangle_mesh.h"
#include "scenes/shape_families/solid_shape.h"

namespace pickbed::scenes {

struct SolidMeshOptions {
  int cells = 48;               // along the longest side of the box; more for thin walls
  double cells_per_wall = 1.8;  // minimum number of cells in the thinnest wall
  double tolerance_share =
      7e-4;  // deviation of the reduced mesh over the longest side; 0 = not reduced
  void Validate() const;
};

// Returns the surface in the frame of the solid, with normals; an edge of more than 40 degrees is
// sharp. Each edge has exactly two faces and the outside is in front of all faces. The result is
// the same on every run. Throws InputError for an empty solid and for options out of range.
TriangleMesh MeshOfSolid(const SolidShape& solid, const SolidMeshOptions& options = {});

}  // namespace pickbed::scenes
