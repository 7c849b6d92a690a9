#pragma once

// The logistic function, 1 / (1 + exp(-x)): from log odds to a probability.

#include <algorithm>
#include <cmath>

namespace pickbed {

inline double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

// A probability after evidence of so many nats (>= 0) against it. What is certain counts as a
// millionth short of it, so that evidence can move it.
inline double LessLikely(double probability, double nats) {
  constexpr double kUnsure = 1e-6;
  const double sure = std::clamp(probability, kUnsure, 1 - kUnsure);
  return std::min(probability, Logistic(std::log(sure / (1 - sure)) - nats));
}

}  // namespace pickbed
