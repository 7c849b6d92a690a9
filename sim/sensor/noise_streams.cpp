#include "sim/sensor/noise_streams.h"

#include <array>
#include <cmath>
#include <numbers>

#include "scenes/camera/mesh_raster_rows.h"

namespace pickbed::sim {
namespace {

// A pixel uses one 64-bit random number: three Gaussians of 12 bits by table, and two uniform
// numbers of 14 bits.
constexpr int kGaussBits = 12;
constexpr int kGaussCount = 1 << kGaussBits;
constexpr int kDecisionBits = 14;
constexpr int kLossShift = 3 * kGaussBits;
constexpr int kFlyingShift = kLossShift + kDecisionBits;
static_assert(kLossShift >= 32 && kFlyingShift + kDecisionBits == 64);

// Returns the random number at a place of the SplitMix64 sequence (Steele, Lea and Flood 2014).
uint64_t MixBits(uint64_t place) {
  uint64_t z = place * 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

// Returns equally likely values of a normal distribution: its inverse distribution function at the
// centers of equal steps, scaled to unit variance.
std::array<float, kGaussCount> MakeGaussTable() {
  std::array<double, kGaussCount> values;
  double sum_of_squares = 0;
  for (int i = 0; i < kGaussCount; ++i) {
    const double p = (i + 0.5) / kGaussCount;
    double low = -8, high = 8;
    for (int step = 0; step < 50; ++step) {
      const double center = 0.5 * (low + high);
      (NormalCdf(center) < p ? low : high) = center;
    }
    values[i] = 0.5 * (low + high);
    sum_of_squares += values[i] * values[i];
  }
  const double scale = 1 / std::sqrt(sum_of_squares / kGaussCount);
  std::array<float, kGaussCount> table;
  for (int i = 0; i < kGaussCount; ++i) table[i] = static_cast<float>(values[i] * scale);
  return table;
}

const std::array<float, kGaussCount>& GaussTable() {
  static const std::array<float, kGaussCount> table = MakeGaussTable();
  return table;
}

// Outputs are marked __restrict (no overlap with inputs), and each loop uses numbers of one size.
// Without both, the compiler does not vectorize the loops.

PICKBED_WIDTHS void DrawBits(uint64_t place, int n, uint64_t* __restrict bits) {
  for (int x = 0; x < n; ++x) bits[x] = MixBits(place + static_cast<uint64_t>(x));
}

PICKBED_WIDTHS void SplitBits(const uint64_t* bits, int n, uint32_t* __restrict lower,
                              uint32_t* __restrict upper) {
  for (int x = 0; x < n; ++x) {
    lower[x] = static_cast<uint32_t>(bits[x]);
    upper[x] = static_cast<uint32_t>(bits[x] >> 32);
  }
}

PICKBED_WIDTHS void Decide(const uint32_t* upper, int n, float* __restrict dropout,
                           float* __restrict flying) {
  constexpr uint32_t kMask = (1 << kDecisionBits) - 1;
  constexpr float kUnit = 1.0f / (1 << kDecisionBits);
  for (int x = 0; x < n; ++x) {
    dropout[x] =
        static_cast<float>(static_cast<int>((upper[x] >> (kLossShift - 32)) & kMask)) * kUnit;
    flying[x] = static_cast<float>(static_cast<int>(upper[x] >> (kFlyingShift - 32))) * kUnit;
  }
}

// Looks up the three Gaussians of a pixel. The bits of the last one span both halves. It is
// compiled for a single vector width, because wide gathers are slower than single loads.
void LookUpGaussians(const uint32_t* lower, const uint32_t* upper, const float* gauss, int n,
                     float* __restrict aside, float* __restrict below, float* __restrict along) {
  constexpr uint32_t kMask = kGaussCount - 1;
  for (int x = 0; x < n; ++x) {
    const uint32_t across = lower[x] >> (2 * kGaussBits) | upper[x] << (32 - 2 * kGaussBits);
    aside[x] = gauss[static_cast<int>(lower[x] & kMask)];
    below[x] = gauss[static_cast<int>((lower[x] >> kGaussBits) & kMask)];
    along[x] = gauss[static_cast<int>(across & kMask)];
  }
}

}  // namespace

double NormalCdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

SensorNumbers::SensorNumbers(int width)
    : dropout(width),
      flying(width),
      aside(width),
      below(width),
      along(width),
      bits_(width),
      lower_(width),
      upper_(width) {}

void SensorNumbers::Draw(uint64_t place) {
  const int n = static_cast<int>(bits_.size());
  DrawBits(place, n, bits_.data());
  SplitBits(bits_.data(), n, lower_.data(), upper_.data());
  Decide(upper_.data(), n, dropout.data(), flying.data());
  LookUpGaussians(lower_.data(), upper_.data(), GaussTable().data(), n, aside.data(), below.data(),
                  along.data());
}

}  // namespace pickbed::sim
