#pragma once

// Seeded random numbers that are the same on every machine and standard library.
//
// Every stage of every trial has its own stream, derived from (scenario seed, trial number, stage
// name). A trial therefore gives the same bytes for any number and order of workers. The generator
// is xoshiro256** by Blackman and Vigna (2018), seeded through SplitMix64. Directions and rotations
// use only square roots (Marsaglia 1972), so they do not depend on the math library.

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace pickbed::scenes {

// A stream of random numbers.
class Rng {
 public:
  explicit Rng(uint64_t seed);

  // Returns the stream of one stage of one trial.
  static Rng Derive(uint64_t seed, uint64_t trial, std::string_view stage);

  uint64_t Next();                          // 64 uniform bits
  double Uniform();                         // [0, 1)
  double Uniform(double low, double high);  // [low, high)
  int Index(int count);                     // 0 .. count-1, unbiased; count >= 1
  double Normal();                          // zero mean, unit variance
  Eigen::Vector3d UnitVector();             // uniform on the sphere
  Eigen::Quaterniond Rotation();            // uniform on SO(3), unit quaternion

 private:
  std::array<uint64_t, 4> state_;
  bool has_spare_ = false;
  double spare_ = 0;
};

// Returns the 64-bit FNV-1a hash of `size` bytes. It is used for cache keys and stage streams.
uint64_t HashBytes(const void* data, size_t size, uint64_t seed = 14695981039346656037ull);

}  // namespace pickbed::scenes
