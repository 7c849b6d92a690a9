#include "perception/candidates/search_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace pickbed::perception {
namespace {

// Neighbouring pixels are on one smooth surface if their normals differ by less than 15 degrees and
// each point is within this distance of the other's plane, at 1 m.
constexpr float kSmoothCos = 0.966f;
constexpr float kSmoothStepAt1m_m = 0.004f;
// A surface of one object does not get larger than this by noise and by slight contact with others.
constexpr double kLargeDiameters = 1.3;
constexpr int kDirections = 7;  // in which the extent is measured

// Sets of pixels, by a representative of each.
class PixelSets {
 public:
  explicit PixelSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Find(int pixel) {
    while (parent_[pixel] != pixel) pixel = parent_[pixel] = parent_[parent_[pixel]];
    return pixel;
  }
  void Join(int a, int b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

bool IsSmooth(const OrganizedCloud& cloud, int a, int b) {
  const Eigen::Vector3f &normal_a = cloud.normals_C[a], &normal_b = cloud.normals_C[b];
  if (!(normal_a.dot(normal_b) > kSmoothCos)) return false;  // also where a normal is zero
  const Eigen::Vector3f &p = cloud.points_C[a], &q = cloud.points_C[b];
  const float step_m = static_cast<float>(cloud.error_scale) * kSmoothStepAt1m_m * p.z() * q.z();
  return std::abs(normal_a.dot(q - p)) < step_m && std::abs(normal_b.dot(q - p)) < step_m;
}

// Extents of a set of points along some directions. The largest is at most their diameter, and
// at least 80 % of it.
class Extents {
 public:
  void Add(const Eigen::Vector3f& p) {
    constexpr float kHalf = 0.57735f;  // 1 / sqrt(3)
    const std::array<float, kDirections> at{p.x(),
                                            p.y(),
                                            p.z(),
                                            kHalf * (p.x() + p.y() + p.z()),
                                            kHalf * (p.x() + p.y() - p.z()),
                                            kHalf * (p.x() - p.y() + p.z()),
                                            kHalf * (p.x() - p.y() - p.z())};
    for (int k = 0; k < kDirections; ++k) {
      low_[k] = is_empty_ ? at[k] : std::min(low_[k], at[k]);
      high_[k] = is_empty_ ? at[k] : std::max(high_[k], at[k]);
    }
    is_empty_ = false;
  }
  float Largest() const {
    float largest = 0;
    for (int k = 0; k < kDirections; ++k) largest = std::max(largest, high_[k] - low_[k]);
    return largest;
  }

 private:
  std::array<float, kDirections> low_{}, high_{};
  bool is_empty_ = true;
};

}  // namespace

std::vector<int> SearchPixels(const OrganizedCloud& cloud, double diameter_m) {
  if (cloud.background == BackgroundKind::kKnown) return cloud.foreground_pixels;
  const int width = cloud.intrinsics.width(), height = cloud.intrinsics.height();
  PixelSets surfaces(cloud.points_C.size());
  for (const int pixel : cloud.foreground_pixels) {
    const int right = pixel + 1, below = pixel + width;
    if (right % width != 0 && IsSmooth(cloud, pixel, right)) surfaces.Join(pixel, right);
    if (below < width * height && IsSmooth(cloud, pixel, below)) surfaces.Join(pixel, below);
  }
  std::vector<Extents> extents(cloud.points_C.size());
  for (const int pixel : cloud.foreground_pixels) {
    extents[surfaces.Find(pixel)].Add(cloud.points_C[pixel]);
  }
  std::vector<int> searched;
  int on_large = 0;
  for (const int pixel : cloud.foreground_pixels) {
    const bool is_large = extents[surfaces.Find(pixel)].Largest() > kLargeDiameters * diameter_m;
    if (!is_large || on_large++ % kLargeSurfaceStride == 0) searched.push_back(pixel);
  }
  return searched;
}

}  // namespace pickbed::perception
