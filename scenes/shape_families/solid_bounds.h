#pragma once

// Tight bounding box of a signed-distance program.

#include <Eigen/Geometry>

#include "scenes/shape_families/solid_program.h"

namespace pickbed::scenes {

// Returns the bounding box (mm) of the program's solid, which must be within `outer` (mm). A grid
// of points on each side of `outer` moves inwards by the smallest distance until it touches. Finer
// grids then search for peaks between its points. The result may be about 0.1 mm too small. Throws
// InputError if the solid is empty.
Eigen::AlignedBox3f TightBox(const SolidProgram& program, const Eigen::AlignedBox3f& outer);

}  // namespace pickbed::scenes
