#include "sim/sensor/window_matching.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/camera/mesh_raster_rows.h"
#include "sim/sensor/image_geometry.h"

namespace pickbed::sim {
namespace {

// Offsets from the places of single pixels, which start at the key.
constexpr uint64_t kErrorPlaces = uint64_t{1} << 40, kDropoutPlaces = uint64_t{2} << 40;

// Table of the normal distribution function in steps of 1 / kPerUnit from -kReach to kReach.
constexpr int kPerUnit = 512, kReach = 5;

std::vector<float> MakeNormalCdf() {
  std::vector<float> table;
  for (int i = 0; i <= 2 * kReach * kPerUnit; ++i) {
    const double x = static_cast<double>(i) / kPerUnit - kReach;
    table.push_back(static_cast<float>(NormalCdf(x)));
  }
  return table;
}

void MakeUniform(std::vector<float>& normal) {
  static const std::vector<float> cdf = MakeNormalCdf();
  for (float& value : normal) {
    const float x = std::clamp(value, static_cast<float>(-kReach), static_cast<float>(kReach));
    value = cdf[static_cast<int>((x + kReach) * kPerUnit + 0.5f)];
  }
}

// Returns interpolation weights of two independent numbers, scaled so that the variance stays 1.
std::array<float, 2> WeightsAt(float share) {
  const float length = std::sqrt((1 - share) * (1 - share) + share * share);
  return {(1 - share) / length, share / length};
}

PICKBED_WIDTHS void BlendRows(const float* upper, const float* lower, float upper_weight,
                              float lower_weight, int n, float* __restrict out) {
  for (int i = 0; i < n; ++i) out[i] = upper_weight * upper[i] + lower_weight * lower[i];
}

void Widen(const float* knots, const int* left, const float* left_weight, const float* right_weight,
           int n, float* __restrict out) {
  for (int x = 0; x < n; ++x) {
    out[x] = left_weight[x] * knots[left[x]] + right_weight[x] * knots[left[x] + 1];
  }
}

}  // namespace

CorrelatedNumbers::CorrelatedNumbers(uint64_t key, int width, double spacing_px)
    : key_(key),
      spacing_px_(spacing_px),
      count_(static_cast<int>((width - 1) / spacing_px) + 2),
      upper_{SensorNumbers(count_), SensorNumbers(count_), -1},
      lower_{SensorNumbers(count_), SensorNumbers(count_), -1},
      row_(count_) {
  for (int x = 0; x < width; ++x) {
    const double at = x / spacing_px;
    left_.push_back(static_cast<int>(at));
    const auto [left, right] = WeightsAt(static_cast<float>(at - left_.back()));
    left_weight_.push_back(left);
    right_weight_.push_back(right);
  }
}

void CorrelatedNumbers::Draw(int row, Knots& knots) const {
  const uint64_t place = key_ + static_cast<uint64_t>(row) * static_cast<uint64_t>(count_);
  knots.errors.Draw(place + kErrorPlaces);
  knots.dropout.Draw(place + kDropoutPlaces);
  knots.row = row;
}

void CorrelatedNumbers::Blend(const std::vector<float>& upper, const std::vector<float>& lower,
                              float share, std::vector<float>& out) {
  const auto [upper_weight, lower_weight] = WeightsAt(share);
  BlendRows(upper.data(), lower.data(), upper_weight, lower_weight, count_, row_.data());
  Widen(row_.data(), left_.data(), left_weight_.data(), right_weight_.data(),
        static_cast<int>(out.size()), out.data());
}

void CorrelatedNumbers::Fill(int y, SensorNumbers& numbers) {
  const double at = y / spacing_px_;
  const int row = static_cast<int>(at);
  if (row != upper_.row) {
    if (row == lower_.row) {
      std::swap(upper_, lower_);
    } else {
      Draw(row, upper_);
    }
    Draw(row + 1, lower_);
  }
  const auto share = static_cast<float>(at - row);
  Blend(upper_.errors.aside, lower_.errors.aside, share, numbers.aside);
  Blend(upper_.errors.below, lower_.errors.below, share, numbers.below);
  Blend(upper_.errors.along, lower_.errors.along, share, numbers.along);
  Blend(upper_.dropout.along, lower_.dropout.along, share, numbers.dropout);
  MakeUniform(numbers.dropout);
}

Image<uint8_t> EdgeDistances_px(const Image<float>& depth_m, float step_m, uint8_t farthest) {
  const int width = depth_m.width(), height = depth_m.height();
  Image<uint8_t> distance(width, height);
  const auto lower = [&](int x, int y, int nx, int ny) {
    if (!distance.Contains(nx, ny)) return;
    const auto over_there = static_cast<uint8_t>(std::min(distance(nx, ny) + 1, int{farthest}));
    distance(x, y) = std::min(distance(x, y), over_there);
  };
  std::vector<uint8_t> is_edge(width);
  // Two-pass distance transform (Rosenfeld and Pfaltz 1966): first from the preceding neighbors,
  // then from the following ones.
  for (int y = 0; y < height; ++y) {
    EdgeRow(depth_m, y, step_m, is_edge.data());
    for (int x = 0; x < width; ++x) {
      distance(x, y) = is_edge[x] ? 0 : farthest;
      lower(x, y, x - 1, y), lower(x, y, x - 1, y - 1);
      lower(x, y, x, y - 1), lower(x, y, x + 1, y - 1);
    }
  }
  for (int y = height - 1; y >= 0; --y) {
    for (int x = width - 1; x >= 0; --x) {
      lower(x, y, x + 1, y), lower(x, y, x + 1, y + 1);
      lower(x, y, x, y + 1), lower(x, y, x - 1, y + 1);
    }
  }
  return distance;
}

}  // namespace pickbed::sim
