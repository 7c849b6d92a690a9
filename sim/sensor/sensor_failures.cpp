#include "sim/sensor/sensor_failures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace pickbed::sim {
namespace {

void RemoveEllipse(Rng& rng, Image<float>& depth_m) {
  const double width = depth_m.width(), height = depth_m.height();
  const double x0 = rng.Uniform(0, width), y0 = rng.Uniform(0, height);
  const double a = width * rng.Uniform(0.005, 0.08), b = a * rng.Uniform(0.2, 1);
  const double angle = rng.Uniform(0, std::numbers::pi);
  const double c = std::cos(angle), s = std::sin(angle);
  const int reach = static_cast<int>(a) + 1;
  const int left = std::max(0, static_cast<int>(x0) - reach);
  const int right = std::min(depth_m.width() - 1, static_cast<int>(x0) + reach);
  const int top = std::max(0, static_cast<int>(y0) - reach);
  const int bottom = std::min(depth_m.height() - 1, static_cast<int>(y0) + reach);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double u = c * (x - x0) + s * (y - y0), v = c * (y - y0) - s * (x - x0);
      if (u * u / (a * a) + v * v / (b * b) < 1) depth_m(x, y) = 0;
    }
  }
}

// Registered depth has no readings along one or two sides.
void RemoveBand(Rng& rng, Image<float>& depth_m) {
  const int columns = 1 + rng.Index(std::max(1, depth_m.width() / 20));
  const bool left = rng.Uniform() < 0.5;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int i = 0; i < columns; ++i) depth_m(left ? i : depth_m.width() - 1 - i, y) = 0;
  }
}

// Replaces each reading by the median or the mean of the readings around it.
void Smooth(bool by_median, Image<float>& depth_m) {
  const Image<float> before = depth_m;
  for (int y = 1; y + 1 < before.height(); ++y) {
    for (int x = 1; x + 1 < before.width(); ++x) {
      if (!(before(x, y) > 0)) continue;
      std::array<float, 9> values{};
      int count = 0;
      float sum = 0;
      for (int v = y - 1; v <= y + 1; ++v) {
        for (int u = x - 1; u <= x + 1; ++u) {
          if (!(before(u, v) > 0)) continue;
          values[count++] = before(u, v);
          sum += before(u, v);
        }
      }
      std::nth_element(values.begin(), values.begin() + count / 2, values.begin() + count);
      depth_m(x, y) = by_median ? values[count / 2] : sum / static_cast<float>(count);
    }
  }
}

}  // namespace

SensorProfile VariedProfile(const SensorProfile& profile, Rng& rng) {
  SensorProfile varied = profile;
  const double noise = std::exp(rng.Uniform(std::log(0.7), std::log(2)));
  varied.axial_floor_m *= noise;
  varied.axial_linear_m *= noise;
  varied.axial_sigma_m *= noise;
  varied.lateral_sigma_px *= rng.Uniform(0.7, 1.5);
  varied.quantization_m *= rng.Uniform(1, 4);
  const auto raise = [&](double share, double more) { return share + (1 - share) * more; };
  varied.random_dropout = raise(profile.random_dropout, rng.Uniform(0, 0.03));
  varied.edge_dropout = raise(profile.edge_dropout, rng.Uniform(0, 0.4));
  return varied;
}

void ApplyFailures(Rng& rng, Image<float>& depth_m) {
  constexpr int kMaxEllipses = 8;
  if (rng.Uniform() < 0.5) return;
  if (rng.Uniform() < 0.5) Smooth(rng.Uniform() < 0.5, depth_m);
  for (int i = rng.Index(kMaxEllipses + 1); i > 0; --i) RemoveEllipse(rng, depth_m);
  if (rng.Uniform() < 0.3) RemoveBand(rng, depth_m);
}

}  // namespace pickbed::sim
