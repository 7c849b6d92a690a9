#pragma once

// The random numbers of a sensor's noise: for each pixel of a row three of a normal distribution
// and two of a uniform one, all from one 64-bit number.

#include <cstdint>
#include <vector>

namespace pickbed {

// Distribution function of the normal distribution of unit variance.
double NormalCdf(double x);

struct SensorNumbers {
  explicit SensorNumbers(int width);

  // The numbers of the `width` places from `place` on of a sequence of 2^64.
  void Draw(uint64_t place);

  std::vector<float> loss, flying;         // uniform in [0, 1), in steps of 2^-14
  std::vector<float> aside, below, along;  // normal, of unit variance, 4096 equally likely values

 private:
  std::vector<uint64_t> bits_;
  std::vector<uint32_t> lower_, upper_;  // halves of the bits
};

}  // namespace pickbed
