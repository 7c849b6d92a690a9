#include "perception/completion/completed_volume.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pickbed::perception {

Eigen::Vector3f CompletedVolume::Center_C(int x, int y, int z) const {
  return origin_C + cell_m * (Eigen::Vector3f(x, y, z) + Eigen::Vector3f::Constant(0.5f));
}

float CompletedVolume::At(const Eigen::Vector3f& p_C) const {
  if (occupancy.empty()) return 0;
  const Eigen::Vector3f in_cells = (p_C - origin_C) / cell_m;
  const float count = static_cast<float>(size);
  if (!(in_cells.minCoeff() >= 0 && in_cells.maxCoeff() <= count)) return 0;
  int first[3], next[3];
  float share[3];
  for (int axis = 0; axis < 3; ++axis) {
    // The outer half cell has the value of its center.
    const float at = std::clamp(in_cells[axis] - 0.5f, 0.0f, count - 1);
    first[axis] = static_cast<int>(at);
    next[axis] = std::min(first[axis] + 1, size - 1);
    share[axis] = at - static_cast<float>(first[axis]);
  }
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    int cell[3];
    float weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = (corner >> axis & 1) != 0;
      cell[axis] = upper ? next[axis] : first[axis];
      weight *= upper ? share[axis] : 1 - share[axis];
    }
    sum += weight * occupancy[Index(cell[0], cell[1], cell[2])];
  }
  return sum;
}

Eigen::Vector3f CompletedVolume::Gradient(const Eigen::Vector3f& p_C) const {
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
  if (empty()) return gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3f step = 0.5f * cell_m * Eigen::Vector3f::Unit(axis);
    gradient[axis] = (At(p_C + step) - At(p_C - step)) / cell_m;
  }
  return gradient;
}

float LevelForIou(const CompletedVolume& volume) {
  // Cells by probability, and the sum of their probabilities.
  constexpr int kSteps = 200;
  std::array<double, kSteps> cells{}, sums{};
  double total = 0;
  for (const float p : volume.occupancy) {
    if (!(p > 0)) continue;
    const int step = std::min(kSteps - 1, static_cast<int>(p * kSteps));
    cells[step] += 1;
    sums[step] += p;
    total += p;
  }
  double best = 0, full = 0, both = 0;
  int best_step = kSteps / 2;
  for (int step = kSteps - 1; step > 0; --step) {
    full += cells[step];
    both += sums[step];
    // The best limit is at most one half. All limits are equal for a volume of zeros and ones.
    if (step > kSteps / 2) continue;
    const double expected = total > 0 ? both / (full + total - both) : 0;
    if (expected <= best) continue;
    best = expected;
    best_step = step;
  }
  return static_cast<float>(best_step) / kSteps;
}

CompletedVolume Smoothed(const CompletedVolume& volume, float sigma_cells) {
  CompletedVolume smoothed = volume;
  if (sigma_cells <= 0 || volume.occupancy.empty()) return smoothed;
  const int radius = static_cast<int>(std::ceil(3 * sigma_cells));
  std::vector<float> kernel(radius + 1);
  float sum = 0;
  for (int i = 0; i <= radius; ++i) {
    const float ratio = static_cast<float>(i) / sigma_cells;
    kernel[i] = std::exp(-0.5f * ratio * ratio);
    sum += i == 0 ? kernel[i] : 2 * kernel[i];
  }
  const int n = volume.size;
  const size_t strides[3] = {1, static_cast<size_t>(n), static_cast<size_t>(n) * n};
  std::vector<float> line(n);
  for (const size_t stride : strides) {
    for (size_t start = 0; start < smoothed.occupancy.size(); ++start) {
      if (start / stride % n != 0) continue;  // the first cell of each line
      float* cells = smoothed.occupancy.data() + start;
      for (int i = 0; i < n; ++i) line[i] = cells[i * stride];
      for (int i = 0; i < n; ++i) {
        float value = 0;
        for (int d = -radius; d <= radius; ++d) {
          if (i + d >= 0 && i + d < n) value += kernel[std::abs(d)] * line[i + d];
        }
        cells[i * stride] = value / sum;
      }
    }
  }
  return smoothed;
}

}  // namespace pickbed::perception
