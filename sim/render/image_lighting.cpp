#include "sim/render/image_lighting.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/parallel.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3f;

constexpr float kOcclusionRadius_m = 0.045f;
constexpr int kOcclusionSamples = 20;
constexpr int kOcclusionStep = 2;  // px between the points at which the occlusion is computed
constexpr int kOcclusionTile = 4;  // the pattern of samples repeats after this number of points

// Directions in the half space z > 0 with lengths in 0..1, more of them short.
std::array<Vector3f, kOcclusionSamples> OcclusionKernel() {
  std::array<Vector3f, kOcclusionSamples> kernel;
  constexpr float kGolden = 2.39996323f;
  for (int i = 0; i < kOcclusionSamples; ++i) {
    const float share = (i + 0.5f) / kOcclusionSamples;
    const float z = std::sqrt(1 - share), radius = std::sqrt(share);
    const float length = 0.12f + 0.88f * ((i * 7) % kOcclusionSamples) / kOcclusionSamples;
    kernel[i] =
        length * Vector3f{radius * std::cos(kGolden * i), radius * std::sin(kGolden * i), z};
  }
  return kernel;
}

}  // namespace

Image<float> AmbientOcclusion(const CameraIntrinsics& k, const Image<float>& depth_m,
                              const Image<Vector3f>& normals_C, int threads) {
  const std::array<Vector3f, kOcclusionSamples> kernel = OcclusionKernel();
  const auto fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  const auto cx = static_cast<float>(k.cx()), cy = static_cast<float>(k.cy());
  const auto raw_at = [&](int u, int v) {
    const float z = depth_m(u, v);
    const Vector3f p_C{(u - cx) / fx * z, (v - cy) / fy * z, z};
    const Vector3f n = normals_C(u, v);
    const Vector3f helper = std::abs(n.z()) < 0.9f ? Vector3f::UnitZ() : Vector3f::UnitX();
    const Vector3f a = n.cross(helper).normalized(), b = n.cross(a);
    const int cell = (u / kOcclusionStep % kOcclusionTile) +
                     kOcclusionTile * (v / kOcclusionStep % kOcclusionTile);
    const float angle = 6.2831853f * ((cell * 7) % 16) / 16;
    const float c = std::cos(angle), s = std::sin(angle);
    float hidden = 0;
    for (const Vector3f& direction : kernel) {
      const float x = c * direction.x() - s * direction.y();
      const float y = s * direction.x() + c * direction.y();
      const Vector3f q = p_C + kOcclusionRadius_m * (x * a + y * b + direction.z() * n);
      if (q.z() <= 0) continue;
      const float qx = fx * q.x() / q.z() + cx + 0.5f, qy = fy * q.y() / q.z() + cy + 0.5f;
      if (!(qx >= 0 && qy >= 0 && qx < depth_m.width() && qy < depth_m.height())) continue;
      const float there = depth_m(static_cast<int>(qx), static_cast<int>(qy));
      const float before = q.z() - there;
      if (there <= 0 || before < 0.0008f) continue;
      // Surfaces far before the sample are not near the point and hide little of it.
      hidden += std::clamp(1.6f - before / kOcclusionRadius_m, 0.0f, 1.0f);
    }
    return std::pow(1 - hidden / kOcclusionSamples, 1.6f);
  };
  const auto rows = (depth_m.height() + kOcclusionStep - 1) / kOcclusionStep;
  const auto columns = (depth_m.width() + kOcclusionStep - 1) / kOcclusionStep;
  Image<float> raw(columns, rows, 1.0f);
  ForRanges(rows, threads, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      for (int i = 0; i < columns; ++i) {
        const int u = i * kOcclusionStep, v = j * kOcclusionStep;
        if (depth_m(u, v) > 0) raw(i, j) = raw_at(u, v);
      }
    }
  });
  // The mean over one tile of the pattern removes its noise. Only points on the same surface count.
  Image<float> smooth(depth_m.width(), depth_m.height(), 1.0f);
  ForRanges(depth_m.height(), threads, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < depth_m.width(); ++u) {
        const float z = depth_m(u, v);
        if (z <= 0) continue;
        const Vector3f& n = normals_C(u, v);
        const int first_i = (u + 1) / kOcclusionStep - kOcclusionTile / 2;
        const int first_j = (v + 1) / kOcclusionStep - kOcclusionTile / 2;
        float sum = 0, count = 0;
        for (int j = first_j; j < first_j + kOcclusionTile; ++j) {
          for (int i = first_i; i < first_i + kOcclusionTile; ++i) {
            if (!raw.Contains(i, j)) continue;
            const int x = i * kOcclusionStep, y = j * kOcclusionStep;
            if (std::abs(depth_m(x, y) - z) > 0.01f || n.dot(normals_C(x, y)) < 0.7f) continue;
            sum += raw(i, j);
            ++count;
          }
        }
        smooth(u, v) = count > 0 ? sum / count : raw_at(u, v);
      }
    }
  });
  return smooth;
}

Image<float> ShadowFactors(const CameraIntrinsics& k, const RenderedImage& thin,
                           const Image<Rgb8>& lit, const Vector3f& key_C, int threads) {
  constexpr float kFacing = 0.08f;  // surfaces that face the lamp less are dark anyway
  const int width = thin.depth_m.width(), height = thin.depth_m.height();
  const auto fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  const auto cx = static_cast<float>(k.cx()), cy = static_cast<float>(k.cy());
  Image<float> sharp(width, height, 1.0f);
  ForRanges(height, threads, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        const float z = thin.depth_m(u, v);
        if (z <= 0) continue;
        const Vector3f p_C{(u - cx) / fx * z, (v - cy) / fy * z, z};
        const float cosine = thin.normals_C(u, v).dot((key_C - p_C).normalized());
        if (cosine < kFacing) continue;
        const Rgb8 own = thin.color(u, v), bright = lit(u, v);
        const float full = cosine * std::max({own.r, own.g, own.b, uint8_t{1}});
        sharp(u, v) = std::min(1.0f, std::max({bright.r, bright.g, bright.b}) / full);
      }
    }
  });
  // The filter of the shadow map has few samples, which leaves stripes.
  constexpr int kReach = 4;
  Image<float> smooth = sharp;
  ForRanges(height, threads, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        const float z = thin.depth_m(u, v), own = sharp(u, v);
        if (z <= 0) continue;
        bool even = true;
        for (const int d : {-kReach, kReach}) {
          even = even && (!sharp.Contains(u + d, v) || std::abs(sharp(u + d, v) - own) < 0.02f) &&
                 (!sharp.Contains(u, v + d) || std::abs(sharp(u, v + d) - own) < 0.02f);
        }
        if (even) continue;
        float sum = 0, count = 0;
        for (int y = v - kReach; y <= v + kReach; y += 2) {
          for (int x = u - kReach; x <= u + kReach; x += 2) {
            if (!sharp.Contains(x, y) || thin.ids(x, y) != thin.ids(u, v)) continue;
            if (thin.normals_C(x, y).dot(thin.normals_C(u, v)) < 0.95f) continue;
            sum += sharp(x, y);
            ++count;
          }
        }
        smooth(u, v) = sum / count;
      }
    }
  });
  return smooth;
}

}  // namespace pickbed::sim
