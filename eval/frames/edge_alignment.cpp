#include "eval/frames/edge_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "perception/cloud/color_edges.h"

namespace pickbed::eval {
namespace {

constexpr int kReach_px = 40;  // largest shift
constexpr int kStep_px = 4;
constexpr int kNear_px = kStep_px / 2;
constexpr std::array<double, 7> kScales{1, 0.8, 0.87, 0.93, 1.08, 1.16, 1.25};

// Gradients above this are equally good edges. Else a few strong ones would decide.
constexpr float kFullGradient = 12;  // grey levels per px

// Strength of the colour edges, 0..1.
Image<float> EdgeStrength(const RgbdFrame& frame) {
  const perception::ColorEdges edges = perception::FindColorEdges(frame.intrinsics, frame.color);
  Image<float> strength(edges.du.width(), edges.du.height());
  for (size_t i = 0; i < strength.size(); ++i) {
    const float gradient = std::hypot(edges.du.data()[i], edges.dv.data()[i]);
    strength.data()[i] = std::min(1.0f, gradient / kFullGradient);
  }
  return strength;
}

// Gives each pixel the largest strength of its neighbours, because depth edges are inaccurate and
// the search has steps.
Image<float> Widened(const Image<float>& strength) {
  Image<float> wide(strength.width(), strength.height());
  for (int y = kNear_px; y + kNear_px < wide.height(); ++y) {
    for (int x = kNear_px; x + kNear_px < wide.width(); ++x) {
      for (int v = y - kNear_px; v <= y + kNear_px; ++v) {
        for (int u = x - kNear_px; u <= x + kNear_px; ++u) {
          wide(x, y) = std::max(wide(x, y), strength(u, v));
        }
      }
    }
  }
  return wide;
}

// Pixels in front of a step to a farther surface. Holes are no steps, since their border is beside
// the edge.
std::vector<Eigen::Vector2d> DepthEdges(const Image<float>& depth_m) {
  constexpr float kMinStep_m = 0.015f, kMinShare = 0.02f;
  constexpr size_t kMaxEdges = 1500;
  std::vector<Eigen::Vector2d> edges;
  const auto add = [&](int x, int y, int u, int v) {
    const float a = depth_m(x, y), b = depth_m(u, v);
    if (!(a > 0) || !(b > 0)) return;
    const float near = std::min(a, b);
    if (std::abs(a - b) < std::max(kMinStep_m, kMinShare * near)) return;
    edges.emplace_back(a < b ? x : u, a < b ? y : v);
  };
  for (int y = 0; y + 1 < depth_m.height(); ++y) {
    for (int x = 0; x + 1 < depth_m.width(); ++x) {
      add(x, y, x + 1, y);
      add(x, y, x, y + 1);
    }
  }
  const size_t stride = edges.size() / kMaxEdges + 1;
  std::vector<Eigen::Vector2d> kept;
  for (size_t i = 0; i < edges.size(); i += stride) kept.push_back(edges[i]);
  return kept;
}

// Mean strength under the edges after the movement; edges that leave the image do not count.
double MeanStrength(const Image<float>& strength, const std::vector<Eigen::Vector2d>& edges,
                    const Eigen::Vector2d& center, double scale, const Eigen::Vector2d& shift) {
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector2d& edge : edges) {
    const Eigen::Vector2d at = center + scale * (edge - center) + shift;
    const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
    if (!strength.Contains(x, y)) continue;
    sum += strength(x, y);
    ++count;
  }
  return 2 * count > static_cast<int>(edges.size()) ? sum / count : 0;
}

// Shift within a step of `coarse` with the largest mean of unwidened strengths.
Eigen::Vector2d RefinedShift(const Image<float>& strength,
                             const std::vector<Eigen::Vector2d>& edges,
                             const Eigen::Vector2d& center, const Eigen::Vector2d& coarse) {
  Eigen::Vector2d best = coarse;
  double best_mean = 0;
  for (int dy = -kStep_px; dy <= kStep_px; ++dy) {
    for (int dx = -kStep_px; dx <= kStep_px; ++dx) {
      const Eigen::Vector2d shift = coarse + Eigen::Vector2d(dx, dy);
      const double mean = MeanStrength(strength, edges, center, 1, shift);
      if (mean <= best_mean) continue;
      best_mean = mean;
      best = shift;
    }
  }
  return best;
}

}  // namespace

double EdgeAlignment::CornerShift_px(const CameraIntrinsics& camera) const {
  double largest = 0;
  for (const double u : {0.0, camera.width() - 1.0}) {
    for (const double v : {0.0, camera.height() - 1.0}) {
      const Eigen::Vector2d from_center(u - camera.cx(), v - camera.cy());
      largest = std::max(largest, ((scale - 1) * from_center + shift_px).norm());
    }
  }
  return largest;
}

std::optional<EdgeAlignment> AlignEdges(const RgbdFrame& frame) {
  constexpr size_t kMinEdges = 200;
  constexpr double kMinPeak = 0.3;     // share by which the best place exceeds the mean of all
  constexpr double kTolerance_px = 4;  // usual error of a registration
  if (frame.color.empty() || frame.color.width() != frame.depth_m.width() ||
      frame.color.height() != frame.depth_m.height()) {
    return std::nullopt;
  }
  const std::vector<Eigen::Vector2d> edges = DepthEdges(frame.depth_m);
  if (edges.size() < kMinEdges) return std::nullopt;
  const Image<float> sharp = EdgeStrength(frame), strength = Widened(sharp);
  const Eigen::Vector2d center(frame.intrinsics.cx(), frame.intrinsics.cy());
  EdgeAlignment best;
  double best_mean = 0, here = 0, sum = 0;
  int count = 0;
  for (const double scale : kScales) {
    for (int dy = -kReach_px; dy <= kReach_px; dy += kStep_px) {
      for (int dx = -kReach_px; dx <= kReach_px; dx += kStep_px) {
        const Eigen::Vector2d shift(dx, dy);
        const double mean = MeanStrength(strength, edges, center, scale, shift);
        if (mean > best_mean) {
          best_mean = mean;
          best.shift_px = shift;
          best.scale = scale;
        }
        if (scale == 1 && shift.norm() <= kTolerance_px) here = std::max(here, mean);
        sum += mean;
        ++count;
      }
    }
  }
  const double base = sum / count;
  if (best_mean < (1 + kMinPeak) * base) return std::nullopt;
  best.fit_here = std::clamp((here - base) / (best_mean - base), 0.0, 1.0);
  if (best.scale == 1) best.shift_px = RefinedShift(sharp, edges, center, best.shift_px);
  return best;
}

}  // namespace pickbed::eval
