#pragma once

// Tick positions of an axis.

#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

// Returns about five tick values from `min` to `max`: multiples of 1, 2 or 5 times a power of ten.
// Returns only `min` if max <= min.
std::vector<double> RoundTicks(double min, double max);

}  // namespace pickbed::eval
