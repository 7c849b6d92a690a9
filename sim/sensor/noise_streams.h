#pragma once

// Random numbers of the sensor noise. Each pixel of a row gets three normal and two uniform
// numbers, all from one 64-bit number.

#include <cstdint>
#include <vector>

#include "sim/layer.h"

namespace pickbed::sim {

// Distribution function of the standard normal distribution.
double NormalCdf(double x);

// Random numbers of one row of pixels.
struct SensorNumbers {
  explicit SensorNumbers(int width);

  // Draws the numbers of `width` consecutive places of a sequence of 2^64, starting at `place`.
  void Draw(uint64_t place);

  std::vector<float> dropout, flying;      // uniform in [0, 1), in steps of 2^-14
  std::vector<float> aside, below, along;  // normal, unit variance, 4096 equally likely values

 private:
  std::vector<uint64_t> bits_;
  std::vector<uint32_t> lower_, upper_;  // halves of the bits
};

}  // namespace pickbed::sim
