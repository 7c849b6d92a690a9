#include "perception/segments/surface_patches.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pickbed::perception {
namespace {

using Eigen::Vector3f;

class PatchFinder {
 public:
  PatchFinder(const OrganizedCloud& cloud, const PatchOptions& options)
      : cloud_(cloud),
        options_(options),
        width_(cloud.depth_m.width()),
        height_(cloud.depth_m.height()),
        min_cosine_(static_cast<float>(std::cos(options.max_normal_rad))) {}

  SurfacePatches Find() {
    found_.of_pixel.assign(cloud_.depth_m.size(), -1);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (cloud_.foreground(x, y) && found_.of_pixel[y * width_ + x] < 0) Grow(x, y);
      }
    }
    for (SurfacePatch& patch : found_.patches) {
      const float pixels = static_cast<float>(patch.pixels);
      patch.center_C /= pixels;
      patch.color /= 255 * pixels;
      if (patch.normal_C.squaredNorm() > 0) patch.normal_C.normalize();
    }
    FindBorders();
    return std::move(found_);
  }

 private:
  bool IsForeground(int pixel) const { return cloud_.foreground.data()[pixel] != 0; }

  // Compares the distance of each pixel from the tangent plane of the other. Without normals, a
  // surface at up to 60 degrees to the image counts as continuous.
  bool IsStep(int a, int b) const {
    const Vector3f &p = cloud_.points_C[a], &q = cloud_.points_C[b];
    const Vector3f &n = cloud_.normals_C[a], &m = cloud_.normals_C[b];
    const Vector3f way = q - p;
    const float z = std::min(p.z(), q.z());
    const float limit = static_cast<float>(options_.step_m) * z * z;
    const bool has_n = n.squaredNorm() > 0, has_m = m.squaredNorm() > 0;
    if (has_n && has_m) return std::max(std::abs(n.dot(way)), std::abs(m.dot(way))) > limit;
    if (has_n || has_m) return std::abs((has_n ? n : m).dot(way)) > limit;
    constexpr float kTangent = 1.73f;
    return std::abs(way.z()) - kTangent * way.head<2>().norm() > limit;
  }

  bool IsCrease(int a, int b) const {
    const Vector3f &n = cloud_.normals_C[a], &m = cloud_.normals_C[b];
    return n.squaredNorm() > 0 && m.squaredNorm() > 0 && n.dot(m) < min_cosine_;
  }

  void Grow(int x, int y) {
    const int number = static_cast<int>(found_.patches.size());
    SurfacePatch& patch = found_.patches.emplace_back();
    const int block = options_.block_px;
    const int x0 = x / block * block, y0 = y / block * block;
    const int x1 = std::min(width_, x0 + block), y1 = std::min(height_, y0 + block);
    stack_.assign(1, y * width_ + x);
    found_.of_pixel[y * width_ + x] = number;
    while (!stack_.empty()) {
      const int pixel = stack_.back();
      stack_.pop_back();
      ++patch.pixels;
      patch.center_C += cloud_.points_C[pixel];
      patch.normal_C += cloud_.normals_C[pixel];
      if (!cloud_.color.empty()) {
        const Rgb8& color = cloud_.color.data()[pixel];
        patch.color += Vector3f(color.r, color.g, color.b);
      }
      const int u = pixel % width_, v = pixel / width_;
      const auto visit = [&](int other) {
        if (!IsForeground(other) || found_.of_pixel[other] >= 0) return;
        if (IsStep(pixel, other) || IsCrease(pixel, other)) return;
        found_.of_pixel[other] = number;
        stack_.push_back(other);
      };
      if (u > x0) visit(pixel - 1);
      if (u + 1 < x1) visit(pixel + 1);
      if (v > y0) visit(pixel - width_);
      if (v + 1 < y1) visit(pixel + width_);
    }
  }

  void FindBorders() {
    struct Pair {
      int64_t key;  // a, then b
      bool is_step;
    };
    const auto patches = static_cast<int64_t>(found_.patches.size());
    std::vector<Pair> pairs;
    const auto add = [&](int p, int q) {
      const int a = found_.of_pixel[p], b = found_.of_pixel[q];
      if (a < 0 || b < 0 || a == b) return;
      pairs.push_back({std::min(a, b) * patches + std::max(a, b), IsStep(p, q)});
    };
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const int pixel = y * width_ + x;
        if (x + 1 < width_) add(pixel, pixel + 1);
        if (y + 1 < height_) add(pixel, pixel + width_);
      }
    }
    std::sort(pairs.begin(), pairs.end(),
              [](const Pair& left, const Pair& right) { return left.key < right.key; });
    int64_t last = -1;
    for (const Pair& pair : pairs) {
      if (pair.key != last) {
        found_.borders.push_back(
            {static_cast<int>(pair.key / patches), static_cast<int>(pair.key % patches), 0, 0});
        last = pair.key;
      }
      ++(pair.is_step ? found_.borders.back().step_px : found_.borders.back().smooth_px);
    }
  }

  const OrganizedCloud& cloud_;
  const PatchOptions& options_;
  const int width_, height_;
  const float min_cosine_;
  std::vector<int> stack_;
  SurfacePatches found_;
};

}  // namespace

void PatchOptions::Visit(SettingsVisitor& v) {
  v.Integer("block_px", block_px, {2, 64}, "edge of the largest patch, px");
  v.Real("step_m", step_m, {1e-5, 0.1},
         "step across the surface that separates neighbouring pixels, m, at 1 m");
  v.Real("max_normal_rad", max_normal_rad, {0.01, 1.6},
         "largest angle between the normals of neighbouring pixels in one patch, rad");
}

SurfacePatches FindPatches(const OrganizedCloud& cloud, const PatchOptions& options) {
  CheckSettings("PatchOptions", options);
  return PatchFinder(cloud, options).Find();
}

}  // namespace pickbed::perception
