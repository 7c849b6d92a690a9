#pragma once

// Finds the rotations that map a mesh onto itself. Only the shape is used.
//
// A symmetry keeps the surface's centroid and maps the principal axes of its second moment onto
// themselves. If two or all three moments are similar, the axes between them are searched on a
// grid. Each candidate rotation is refined by point-to-plane ICP of the surface onto itself and
// then checked strictly. The method follows Mitra, Guibas and Pauly 2006, but uses moments in place
// of their votes.

#include "scenes/geometry/symmetry.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

struct SymmetryOptions {
  // A symmetry must move 997 of 1000 surface points to within this distance of the surface. The
  // unit is the diameter of the mesh. A body of revolution may have dents: a rotation must then
  // move 75 % of the points to within this distance, 95 % to within three and 99 % to within eight
  // times. Teeth and hexagons are no dents, since they repeat.
  double tolerance_diameters = 0.01;
  int samples = 1500;  // surface points
  int max_order = 60;  // of a discrete axis; gears with more teeth appear continuous or are missed
};

// Returns the symmetries in the mesh's frame O. discrete_O is the complete group without the
// identity and without rotations about the continuous axes. Two continuous axes mean a ball. Color
// is ignored. Throws InputError when the mesh has no area.
SymmetrySet FindSymmetries(const TriangleMesh& mesh, const SymmetryOptions& options = {});

}  // namespace pickbed::scenes
