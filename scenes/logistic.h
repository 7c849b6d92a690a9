#pragma once

// The logistic function, 1 / (1 + exp(-x)): from log odds to a probability.

#include <cmath>

namespace pickbed {

inline double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

}  // namespace pickbed
