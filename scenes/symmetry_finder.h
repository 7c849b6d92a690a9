#pragma once

// Finds the rotations that map a mesh onto itself, from its shape alone.
//
// A symmetry keeps the surface's centroid and maps the principal axes of its second moment onto
// themselves. Where two or all three moments are alike, the axes between them are searched on a
// grid. Each candidate turn is polished by point-to-plane ICP of the surface onto itself and then
// judged strictly. (After Mitra, Guibas and Pauly 2006, with moments in place of their votes.)

#include "scenes/symmetry.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

struct SymmetryOptions {
  // 997 of 1000 surface points come to lie within this share of the diameter of the surface.
  double tolerance_diameters = 0.01;
  int samples = 1500;  // surface points
  int max_order = 60;  // of a discrete axis; gears with more teeth look continuous or stay unfound
};

// In the mesh's frame O: discrete_O holds the whole group without the identity and without what
// continuous axes already do; two continuous axes mean a ball. Colour is not looked at. Throws
// InputError when the mesh has no area.
SymmetrySet FindSymmetries(const TriangleMesh& mesh, const SymmetryOptions& options = {});

}  // namespace pickbed
