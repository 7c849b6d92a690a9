#pragma once

// Tight bounding box of a signed-distance program.

#include <Eigen/Geometry>

#include "scenes/shape_families/solid_program.h"

namespace pickbed::scenes {

// Returns the bounding box (mm) of the program's solid, which must be within `outer` (mm). A grid
// of points on each side of `outer` moves inwards by the least distance until it touches, first
// over the whole side and then around the place that it touched. Peaks narrower than 1/32 of a
// side may be cut by a few hundredths of their width. Throws InputError if the solid is empty.
Eigen::AlignedBox3f TightBox(const SolidProgram& program, const Eigen::AlignedBox3f& outer);

}  // namespace pickbed::scenes
