#include "perception/cloud/normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

// Eight pixels are processed at a time. The compiler splits the vectors if the processor has
// narrower registers.
constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using Bits = int32_t __attribute__((vector_size(kLanes * sizeof(float))));

// Moments of the neighbours that take part. Offsets (du, dv) and inverse depth q are relative to
// the center pixel.
enum Moment { kN, kU, kV, kUU, kUV, kVV, kQ, kUQ, kVQ, kQQ, kMoments };
using MomentBlock = std::array<std::array<float, kLanes>, kMoments>;

// `center` points to the inverse depth of eight pixels in rows of `pitch` floats. The window around
// each of them must be readable.
__attribute__((target_clones("avx2", "default"))) void SumWindow(const float* center, int pitch,
                                                                 int radius, float band,
                                                                 MomentBlock& out) {
  Lanes c, total[kMoments] = {};
  std::memcpy(&c, center, sizeof(c));
  const Lanes limit = c * band;
  for (int dv = -radius; dv <= radius; ++dv) {
    Lanes n = {}, u = {}, uu = {}, q = {}, uq = {}, qq = {};
    for (int du = -radius; du <= radius; ++du) {
      Lanes d;
      std::memcpy(&d, center + dv * pitch + du, sizeof(d));
      d -= c;
      const Bits inside = (d < limit) & (-d < limit);
      d = reinterpret_cast<Lanes>(reinterpret_cast<Bits>(d) & inside);
      const Lanes one = Lanes{} + 1.0f;
      const Lanes w = reinterpret_cast<Lanes>(reinterpret_cast<Bits>(one) & inside);
      const float f = static_cast<float>(du);
      n += w;
      u += f * w;
      uu += f * f * w;
      q += d;
      uq += f * d;
      qq += d * d;
    }
    const float f = static_cast<float>(dv);
    total[kN] += n;
    total[kU] += u;
    total[kV] += f * n;
    total[kUU] += uu;
    total[kUV] += f * u;
    total[kVV] += f * f * n;
    total[kQ] += q;
    total[kUQ] += uq;
    total[kVQ] += f * q;
    total[kQQ] += qq;
  }
  std::memcpy(&out, total, sizeof(out));
}

// Plane at one pixel: inverse depth, its slopes per pixel, and the variance of the residuals.
struct Fit {
  float q = 0, du = 0, dv = 0;
  float variance = -1;  // < 0: no fit
};

Fit SolveRegression(const MomentBlock& m, int lane, float q0, int window, double min_support) {
  const auto get = [&](Moment moment) { return m[moment][lane]; };
  const float n = get(kN);
  if (n < min_support * window * window) return {};
  const float mu = get(kU) / n, mv = get(kV) / n, mq = get(kQ) / n;
  const float cuu = get(kUU) / n - mu * mu, cvv = get(kVV) / n - mv * mv;
  const float cuv = get(kUV) / n - mu * mv;
  const float cuq = get(kUQ) / n - mu * mq, cvq = get(kVQ) / n - mv * mq;
  const float det = cuu * cvv - cuv * cuv;
  // A full window has variance (w^2 - 1) / 12 in each direction. A strip along an edge does not
  // determine the slope across it; its determinant is a small share of the full one.
  constexpr float kMinSpread = 0.1f;
  const float full = static_cast<float>(window * window - 1) / 12.0f;
  if (det < kMinSpread * full * full) return {};
  Fit fit;
  fit.du = (cuq * cvv - cvq * cuv) / det;
  fit.dv = (cvq * cuu - cuq * cuv) / det;
  fit.q = q0 + mq - fit.du * mu - fit.dv * mv;
  // The plane uses three of the n degrees of freedom.
  const float squared = get(kQQ) / n - mq * mq - fit.du * cuq - fit.dv * cvq;
  fit.variance = std::max(0.0f, squared) * n / (n - 3);
  return fit;
}

struct Run {
  int begin, end;
};

// Ranges of a row to process. A gap shorter than a block is bridged: a new block would cost more.
std::vector<Run> MaskedRuns(const uint8_t* mask, int width) {
  std::vector<Run> runs;
  for (int x = 0; x < width; ++x) {
    if (!mask[x]) continue;
    if (!runs.empty() && x - runs.back().end < kLanes) {
      runs.back().end = x + 1;
    } else {
      runs.push_back({x, x + 1});
    }
  }
  return runs;
}

// Smallest rectangle with all pixels that are not 0. It is often half of the image: the bin does
// not fill it.
ImageBox BoxOf(const Image<uint8_t>& mask) {
  int left = mask.width(), right = -1, top = mask.height(), bottom = -1;
  for (int y = 0; y < mask.height(); ++y) {
    const uint8_t* row = mask.row(y);
    const uint8_t* end = row + mask.width();
    const auto is_set = [](uint8_t value) { return value != 0; };
    const uint8_t* first = std::find_if(row, end, is_set);
    if (first == end) continue;
    const uint8_t* last = end - 1;
    while (*last == 0) --last;
    left = std::min(left, static_cast<int>(first - row));
    right = std::max(right, static_cast<int>(last - row));
    top = std::min(top, y);
    bottom = y;
  }
  return bottom < 0 ? ImageBox{} : ImageBox{left, top, right - left + 1, bottom - top + 1};
}

// Plane fits of the pixels in the box around the mask. Pixels are given relative to the box.
class PlaneFits {
 public:
  PlaneFits(const Image<float>& depth_m, const Image<uint8_t>& mask, const ImageBox& box,
            const PlaneFitOptions& options, int threads)
      : options_(options),
        radius_(options.window_px / 2),
        // The border of zeros is outside every band. On the right it also covers the rest of a
        // block.
        q_(box.width + 2 * radius_ + kLanes, box.height + 2 * radius_),
        fits_(box.width, box.height) {
    ForRanges(box.height, threads, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        const float* z = depth_m.row(box.y + y) + box.x;
        const uint8_t* m = mask.row(box.y + y) + box.x;
        float* out = q_.row(y + radius_) + radius_;
        for (int x = 0; x < box.width; ++x) out[x] = m[x] && z[x] > 0 ? 1.0f / z[x] : 0.0f;
      }
    });
    ForRanges(box.height, threads, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        for (const Run& run : MaskedRuns(mask.row(box.y + y) + box.x, box.width)) FitRun(y, run);
      }
    });
  }

  // Selects the plane of the center window or of a side window, evaluated at the pixel.
  Fit Choose(int x, int y) const {
    const Fit& center = fits_(x, y);
    Fit best = center;
    const float q0 = InverseDepth(x, y);
    // A pixel whose own window has no fit (a corner) takes any plane that passes through it.
    float limit = center.variance < 0
                      ? std::numeric_limits<float>::max()
                      : static_cast<float>(options_.side_variance) * center.variance;
    for (int dy = -radius_; dy <= radius_; dy += radius_) {
      for (int dx = -radius_; dx <= radius_; dx += radius_) {
        if ((dx == 0 && dy == 0) || !fits_.Contains(x + dx, y + dy)) continue;
        const Fit& side = fits_(x + dx, y + dy);
        if (side.variance < 0 || side.variance >= limit) continue;
        const float q =
            side.q - side.du * static_cast<float>(dx) - side.dv * static_cast<float>(dy);
        const auto sigmas = static_cast<float>(options_.side_sigmas);
        if ((q - q0) * (q - q0) > sigmas * sigmas * side.variance) continue;
        limit = side.variance;
        best = {q, side.du, side.dv, side.variance};
      }
    }
    return best;
  }

  float InverseDepth(int x, int y) const { return q_(x + radius_, y + radius_); }

 private:
  void FitRun(int y, const Run& run) {
    MomentBlock moments;
    for (int x = run.begin; x < run.end; x += kLanes) {
      const float* center = q_.row(y + radius_) + radius_ + x;
      SumWindow(center, q_.width(), radius_, static_cast<float>(options_.band_m), moments);
      for (int lane = 0; lane < kLanes && x + lane < run.end; ++lane) {
        if (!(center[lane] > 0)) continue;
        fits_(x + lane, y) =
            SolveRegression(moments, lane, center[lane], options_.window_px, options_.min_support);
      }
    }
  }

  PlaneFitOptions options_;
  int radius_;
  Image<float> q_;
  Image<Fit> fits_;
};

}  // namespace

void FitPlanes(const CameraIntrinsics& k, const Image<uint8_t>& mask,
               const PlaneFitOptions& options, Image<float>& depth_m,
               std::vector<Eigen::Vector3f>& normals_C, int threads) {
  const float band = static_cast<float>(options.band_m);
  const float min_cos = static_cast<float>(options.min_incidence_cos);
  const ImageBox box = BoxOf(mask);
  const PlaneFits fits(depth_m, mask, box, options, threads);
  const auto fit_row = [&](int y) {
    const float ray_y = static_cast<float>((y - k.cy()) / k.fy());
    for (int x = box.x; x < box.x + box.width; ++x) {
      const float q0 = fits.InverseDepth(x - box.x, y - box.y);
      if (!(q0 > 0)) continue;
      const Fit fit = fits.Choose(x - box.x, y - box.y);
      if (fit.variance < 0 || std::abs(fit.q - q0) > band * q0) continue;
      // A plane g . p = 1 has 1/z = g . ray, ray = ((u - cx) / fx, (v - cy) / fy, 1).
      const float ray_x = static_cast<float>((x - k.cx()) / k.fx());
      const float gx = fit.du * static_cast<float>(k.fx()),
                  gy = fit.dv * static_cast<float>(k.fy());
      const Eigen::Vector3f g(gx, gy, fit.q - gx * ray_x - gy * ray_y);
      const float g_norm = g.norm();
      const float ray_norm = std::sqrt(ray_x * ray_x + ray_y * ray_y + 1);
      if (fit.q < min_cos * g_norm * ray_norm) continue;
      depth_m(x, y) = 1.0f / fit.q;
      normals_C[static_cast<size_t>(y) * mask.width() + x] = -g / g_norm;
    }
  };
  ForRanges(mask.height(), threads, [&](int begin, int end) {
    const auto first = normals_C.begin();
    std::fill(first + static_cast<std::ptrdiff_t>(begin) * mask.width(),
              first + static_cast<std::ptrdiff_t>(end) * mask.width(), Eigen::Vector3f::Zero());
    for (int y = std::max(begin, box.y); y < std::min(end, box.y + box.height); ++y) fit_row(y);
  });
}

}  // namespace pickbed::perception
