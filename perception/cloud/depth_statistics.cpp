#include "perception/cloud/depth_statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes/camera/filled_depth.h"

namespace pickbed::perception {
namespace {

constexpr int kRowStep = 4;
constexpr float kMaxStep = 0.02f;  // of the depth; larger differences are edges

// Element with this share of the others below it. Changes the order; the vector is not empty.
float Quantile(std::vector<float>& values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<size_t>(at)];
}

}  // namespace

double DepthStatistics::Error_m() const {
  return std::sqrt(noise_at_1m_m * noise_at_1m_m + step_at_1m_m * step_at_1m_m / 12);
}

DepthStatistics MeasureDepth(const Image<float>& depth_m) {
  constexpr size_t kMinReadings = 100;
  constexpr double kStepQuantile = 0.25;  // larger differences are several steps
  DepthStatistics result;
  std::vector<float> bends, steps;
  int holes = 0, pixels = 0;
  for (int y = kRowStep / 2; y < depth_m.height(); y += kRowStep) {
    int first = depth_m.width(), last = -1, readings = 0;
    for (int x = 0; x < depth_m.width(); ++x) {
      const float z = depth_m(x, y);
      if (!IsReading(z)) continue;
      first = std::min(first, x);
      last = x;
      ++readings;
      if (x == 0 || x + 1 == depth_m.width()) continue;
      const float left = depth_m(x - 1, y), right = depth_m(x + 1, y);
      if (!(left > 0) || !(z * z > 0) || !(right > 0)) continue;  // the square can underflow
      const float bend = std::abs(z - 0.5f * (left + right));
      const float step = std::abs(right - z);
      if (bend < kMaxStep * z) bends.push_back(bend / (z * z));
      if (step > 0 && step < kMaxStep * z) steps.push_back(step / (z * z));
    }
    // The image of a bin without surroundings has no readings outside of it; this is no failure.
    if (last < first) continue;
    pixels += last - first + 1;
    holes += last - first + 1 - readings;
  }
  if (pixels > 0) result.hole_share = static_cast<double>(holes) / pixels;
  if (bends.size() < kMinReadings) return result;
  // The median of |x| is 0.6745 sigma; a bend has the variance 1.5 sigma^2.
  result.noise_at_1m_m = Quantile(bends, 0.5) / (0.6745 * std::sqrt(1.5));
  // Where most neighbours are equal, the median does not see the steps between them.
  if (steps.size() >= kMinReadings) result.step_at_1m_m = Quantile(steps, kStepQuantile);
  return result;
}

double ErrorScale(const DepthStatistics& statistics) {
  return std::clamp(statistics.Error_m() / kMaxTrainedError_m, 1.0, 4.0);
}

}  // namespace pickbed::perception
