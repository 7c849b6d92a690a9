#pragma once

// Conversions between probabilities and log odds.

#include <algorithm>
#include <cmath>

namespace pickbed::scenes {

// Returns the logistic function 1 / (1 + exp(-x)), the probability for log odds `x`.
inline double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

// Returns `probability` after evidence against it of `nats` (>= 0, natural log odds). The input is
// first clamped to [1e-6, 1 - 1e-6], so that evidence also changes a probability of 1. The result
// never exceeds `probability`.
inline double LessLikely(double probability, double nats) {
  constexpr double kUnsure = 1e-6;
  const double sure = std::clamp(probability, kUnsure, 1 - kUnsure);
  return std::min(probability, Logistic(std::log(sure / (1 - sure)) - nats));
}

}  // namespace pickbed::scenes
