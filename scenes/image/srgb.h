#pragma once

// Conversion between linear light and the values of an sRGB image, IEC 61966-2-1. All values are in
// 0..1.

#include <algorithm>
#include <cmath>

namespace pickbed::scenes {

inline float LinearOfSrgb(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

// Limits the value to 0..1 first.
inline float SrgbOfLinear(float linear) {
  const float limited = std::clamp(linear, 0.0f, 1.0f);
  return limited <= 0.0031308f ? 12.92f * limited : 1.055f * std::pow(limited, 1 / 2.4f) - 0.055f;
}

}  // namespace pickbed::scenes
