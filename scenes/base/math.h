#pragma once

// Conversions of angles, and between probabilities and log odds.

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pickbed::scenes {

inline constexpr double kDegreesPerRadian = 180 / std::numbers::pi;
inline constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// Convert an angle. They multiply before they divide, so that they are exact for 180 degrees. The
// last bit can differ from a product with one of the constants above.
constexpr double Degrees(double angle_rad) { return angle_rad * 180 / std::numbers::pi; }
constexpr double Radians(double angle_deg) { return angle_deg * std::numbers::pi / 180; }

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
