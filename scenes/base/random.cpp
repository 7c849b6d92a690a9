#include "scenes/base/random.h"

#include <bit>
#include <cmath>
#include <stdexcept>

namespace pickbed::scenes {
namespace {

constexpr uint64_t kGoldenGamma = 0x9e3779b97f4a7c15ull;

// Output function of SplitMix64 (Steele, Lea and Flood 2014). It is a bijection of 64 bits in which
// each input bit flips each output bit with probability one half.
uint64_t Mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

}  // namespace

Rng::Rng(uint64_t seed) {
  // The all-zero state is invalid for xoshiro. SplitMix64 never gives four zeros in a row.
  for (uint64_t& word : state_) word = Mix(seed += kGoldenGamma);
}

Rng Rng::Derive(uint64_t seed, uint64_t trial, std::string_view stage) {
  uint64_t key = Mix(seed + kGoldenGamma);
  key = Mix((key ^ trial) + kGoldenGamma);
  key = Mix((key ^ HashBytes(stage.data(), stage.size())) + kGoldenGamma);
  return Rng(key);
}

uint64_t Rng::Next() {
  const uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
  const uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Rng::Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }

double Rng::Uniform(double low, double high) {
  const double x = low + (high - low) * Uniform();
  return x < high ? x : low;  // rounding may reach `high`, which is outside the interval
}

int Rng::Index(int count) {
  if (count < 1) throw std::invalid_argument("Rng::Index needs a positive count");
  // Lemire 2019: multiply and keep the high word; reject the few low words that would cause a bias.
  const uint32_t range = static_cast<uint32_t>(count);
  uint64_t product = (Next() >> 32) * range;
  if (static_cast<uint32_t>(product) < range) {
    const uint32_t threshold = -range % range;
    while (static_cast<uint32_t>(product) < threshold) product = (Next() >> 32) * range;
  }
  return static_cast<int>(product >> 32);
}

double Rng::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Marsaglia's polar method gives two normal samples from a point in the unit disc.
  double u, v, s;
  do {
    u = 2 * Uniform() - 1;
    v = 2 * Uniform() - 1;
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double factor = std::sqrt(-2 * std::log(s) / s);
  spare_ = v * factor;
  has_spare_ = true;
  return u * factor;
}

Eigen::Vector3d Rng::UnitVector() {
  double u, v, s;
  do {
    u = 2 * Uniform() - 1;
    v = 2 * Uniform() - 1;
    s = u * u + v * v;
  } while (s >= 1);
  const double factor = 2 * std::sqrt(1 - s);
  return {u * factor, v * factor, 1 - 2 * s};
}

Eigen::Quaterniond Rng::Rotation() {
  double a, b, c, d, s, t;
  do {
    a = 2 * Uniform() - 1;
    b = 2 * Uniform() - 1;
    s = a * a + b * b;
  } while (s >= 1);
  do {
    c = 2 * Uniform() - 1;
    d = 2 * Uniform() - 1;
    t = c * c + d * d;
  } while (t >= 1 || t == 0);
  const double factor = std::sqrt((1 - s) / t);
  return Eigen::Quaterniond(a, b, c * factor, d * factor);
}

uint64_t HashBytes(const void* data, size_t size, uint64_t seed) {
  const unsigned char* bytes = static_cast<const unsigned char*>(data);
  uint64_t hash = seed;
  for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  return hash;
}

}  // namespace pickbed::scenes
