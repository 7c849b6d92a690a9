#pragma once

// Contact sheet of an object as derived from its mesh: views, pieces, symmetries, resting poses.

#include <string>

#include "eval/layer.h"
#include "sim/drop/object_maker.h"

namespace pickbed::eval {

inline constexpr char kObjectSheetFile[] = "sheet.png";  // in the folder of an object

// Draws the sheet.
Image<Rgb8> ObjectSheet(const MadeObject& made);

// The same facts as text, one per line.
std::string ObjectText(const MadeObject& made);

// One line, for example "6-fold about z, and flips" or "any rotation about [0, 0, 1]".
std::string SymmetryText(const SymmetrySet& symmetries);

}  // namespace pickbed::eval
