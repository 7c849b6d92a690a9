#pragma once

// Where an axis is marked.

#include <vector>

namespace pickbed {

// Multiples of 1, 2 or 5 times a power of ten from `min` to `max`, about five of them; `min` alone
// where max <= min.
std::vector<double> RoundTicks(double min, double max);

}  // namespace pickbed
