#pragma once

// Contact sheet of the shape families: one sampled shape of each, scaled to its tile.

#include "eval/layer.h"
#include "scenes/image/image.h"
#include "scenes/shape_families/shape_family.h"

namespace pickbed::eval {

// Draws the shapes of all families with this split and seed. A caption has the family's name, the
// longest side in mm, and a star for a family that is held out.
Image<Rgb8> FamilySheet(ShapeSplit split, uint64_t seed);

}  // namespace pickbed::eval
