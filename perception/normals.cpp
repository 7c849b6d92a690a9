#include "perception/normals.h"

#include <algorithm>
#include <cmath>

namespace pickbed {
namespace {

// Moments of the neighbours that take part, one entry per pixel of a row; offsets (du, dv) and
// inverse depth q are relative to the pixel in the middle.
struct Moments {
  explicit Moments(size_t width)
      : n(width),
        u(width),
        v(width),
        uu(width),
        uv(width),
        vv(width),
        q(width),
        uq(width),
        vq(width) {}
  std::vector<float> n, u, v, uu, uv, vv, q, uq, vq;
};

struct Run {
  int begin, end;
};

// Stretches of a row to be worked on; short gaps are bridged, since vector loops want length.
std::vector<Run> MaskedRuns(const uint8_t* mask, int width) {
  constexpr int kBridge = 16;
  std::vector<Run> runs;
  for (int x = 0; x < width; ++x) {
    if (!mask[x]) continue;
    if (!runs.empty() && x - runs.back().end < kBridge) {
      runs.back().end = x + 1;
    } else {
      runs.push_back({x, x + 1});
    }
  }
  return runs;
}

// Sums over the window's row at `dv` for `count` pixels. `center` points to the pixels' inverse
// depth, `row` to that of the row dv below them. Plain loops: the compiler makes vectors of them.
__attribute__((target_clones("avx2", "default"))) void AddWindowRow(
    const float* __restrict center, const float* __restrict row, int count, int radius, float dv,
    float band, float* __restrict n, float* __restrict u, float* __restrict v, float* __restrict uu,
    float* __restrict uv, float* __restrict vv, float* __restrict q, float* __restrict uq,
    float* __restrict vq) {
  for (int du = -radius; du <= radius; ++du) {
    const float* __restrict neighbor = row + du;
    const float fu = static_cast<float>(du);
    for (int i = 0; i < count; ++i) {
      const float dq = neighbor[i] - center[i];
      const float w = std::abs(dq) < band * center[i] ? 1.0f : 0.0f;
      const float wu = w * fu, wv = w * dv, wq = w * dq;
      n[i] += w;
      u[i] += wu;
      v[i] += wv;
      uu[i] += wu * fu;
      uv[i] += wu * dv;
      vv[i] += wv * dv;
      q[i] += wq;
      uq[i] += wq * fu;
      vq[i] += wq * dv;
    }
  }
}

void ClearMoments(Moments& m, const Run& run) {
  for (std::vector<float>* a : {&m.n, &m.u, &m.v, &m.uu, &m.uv, &m.vv, &m.q, &m.uq, &m.vq}) {
    std::fill(a->begin() + run.begin, a->begin() + run.end, 0.0f);
  }
}

// Regression of q on (u, v): slopes and the fitted value relative to the middle pixel's.
struct Slopes {
  bool ok = false;
  float du = 0, dv = 0, offset = 0;
};

Slopes SolveRegression(const Moments& m, int i, int window, double min_support) {
  const float n = m.n[i];
  if (n < min_support * window * window) return {};
  const float mu = m.u[i] / n, mv = m.v[i] / n, mq = m.q[i] / n;
  const float cuu = m.uu[i] / n - mu * mu, cvv = m.vv[i] / n - mv * mv;
  const float cuv = m.uv[i] / n - mu * mv;
  const float cuq = m.uq[i] / n - mu * mq, cvq = m.vq[i] / n - mv * mq;
  const float det = cuu * cvv - cuv * cuv;
  // A full window has variance (w^2 - 1) / 12 in each direction; a strip along an edge, that says
  // nothing about the slope across, has a small part of its determinant.
  constexpr float kMinSpread = 0.1f;
  const float full = static_cast<float>(window * window - 1) / 12.0f;
  if (det < kMinSpread * full * full) return {};
  Slopes s;
  s.ok = true;
  s.du = (cuq * cvv - cvq * cuv) / det;
  s.dv = (cvq * cuu - cuq * cuv) / det;
  s.offset = mq - s.du * mu - s.dv * mv;
  return s;
}

// Inverse depth with a border of zeros, which are in nobody's band.
Image<float> PaddedInverseDepth(const Image<float>& depth_m, const Image<uint8_t>& mask,
                                int border) {
  Image<float> q(depth_m.width() + 2 * border, depth_m.height() + 2 * border);
  for (int y = 0; y < depth_m.height(); ++y) {
    const float* z = depth_m.row(y);
    const uint8_t* m = mask.row(y);
    float* out = q.row(y + border) + border;
    for (int x = 0; x < depth_m.width(); ++x) out[x] = m[x] && z[x] > 0 ? 1.0f / z[x] : 0.0f;
  }
  return q;
}

}  // namespace

void FitPlanes(const CameraIntrinsics& k, const Image<uint8_t>& mask,
               const PlaneFitOptions& options, Image<float>& depth_m,
               std::vector<Eigen::Vector3f>& normals_C) {
  const int radius = options.window_px / 2;
  const float band = static_cast<float>(options.band_m);
  const float fx = static_cast<float>(k.fx), fy = static_cast<float>(k.fy);
  const Image<float> q = PaddedInverseDepth(depth_m, mask, radius);
  Moments m(depth_m.width());
  for (int y = 0; y < depth_m.height(); ++y) {
    const float dv_cy = static_cast<float>(y - k.cy);
    for (const Run& run : MaskedRuns(mask.row(y), depth_m.width())) {
      ClearMoments(m, run);
      const int b = run.begin;
      const float* center = q.row(y + radius) + radius + b;
      for (int dv = -radius; dv <= radius; ++dv) {
        AddWindowRow(center, q.row(y + radius + dv) + radius + b, run.end - b, radius,
                     static_cast<float>(dv), band, &m.n[b], &m.u[b], &m.v[b], &m.uu[b], &m.uv[b],
                     &m.vv[b], &m.q[b], &m.uq[b], &m.vq[b]);
      }
      for (int x = b; x < run.end; ++x) {
        const float q0 = center[x - b];
        if (q0 <= 0) continue;
        const Slopes s = SolveRegression(m, x, options.window_px, options.min_support);
        if (!s.ok || std::abs(s.offset) > band * q0) continue;
        // A plane g . p = 1 has 1/z = g . ray, ray = ((u - cx) / fx, (v - cy) / fy, 1).
        const float du_cx = static_cast<float>(x - k.cx);
        const float fitted = q0 + s.offset;
        const Eigen::Vector3f g(s.du * fx, s.dv * fy, fitted - s.du * du_cx - s.dv * dv_cy);
        const float ray_norm = Eigen::Vector3f(du_cx / fx, dv_cy / fy, 1.0f).norm();
        const float g_norm = g.norm();
        if (fitted < options.min_incidence_cos * g_norm * ray_norm) continue;
        depth_m(x, y) = 1.0f / fitted;
        normals_C[static_cast<size_t>(y) * depth_m.width() + x] = -g / g_norm;
      }
    }
  }
}

}  // namespace pickbed
