#pragma once

// One picture that shows what was understood of a mesh: views, pieces, symmetries, resting poses.

#include <string>

#include "sim/object_maker.h"

namespace pickbed {

Image<Rgb8> ObjectSheet(const MadeObject& made);

// The same in words, a fact a line.
std::string ObjectText(const MadeObject& made);

// "continuous about [0, 0, 1], 1 flip" and the like.
std::string SymmetryText(const SymmetrySet& symmetries);

}  // namespace pickbed
