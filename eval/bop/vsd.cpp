#include "eval/bop/vsd.h"

#include <algorithm>
#include <cmath>

#include "scenes/camera/depth_points.h"

namespace pickbed::eval {
namespace {

float DistanceAt(const DistanceCrop& silhouette, int u, int v) {
  const int x = u - silhouette.x, y = v - silhouette.y;
  return silhouette.distances_m.Contains(x, y) ? silhouette.distances_m(x, y) : 0;
}

bool IsVisible(float model_m, float measured_m, double delta_m) {
  return model_m > 0 && (measured_m == 0 || model_m - measured_m <= delta_m);
}

}  // namespace

Image<float> DistancesOf(const Image<float>& depth_m, const CameraIntrinsics& camera) {
  Image<float> distances_m(depth_m.width(), depth_m.height());
  ForEachDepthPoint(camera, depth_m, [&](int u, int v, const Eigen::Vector3d& p_C) {
    distances_m(u, v) = static_cast<float>(p_C.norm());
  });
  return distances_m;
}

DistanceCrop DistanceCropOf(const Image<float>& depth_m, const CameraIntrinsics& camera) {
  int left = depth_m.width(), top = depth_m.height(), right = -1, bottom = -1;
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (depth_m(u, v) <= 0) continue;
      left = std::min(left, u);
      right = std::max(right, u);
      top = std::min(top, v);
      bottom = v;
    }
  }
  DistanceCrop silhouette;
  if (right < 0) return silhouette;
  silhouette.x = left;
  silhouette.y = top;
  silhouette.distances_m = Image<float>(right - left + 1, bottom - top + 1);
  for (int v = top; v <= bottom; ++v) {
    for (int u = left; u <= right; ++u) {
      if (depth_m(u, v) <= 0) continue;
      silhouette.distances_m(u - left, v - top) =
          static_cast<float>(BackProject(camera, u, v, depth_m(u, v)).norm());
    }
  }
  return silhouette;
}

std::vector<double> Vsd(const DistanceCrop& estimated, const DistanceCrop& truth,
                        const Image<float>& measured_distances_m, double diameter_m,
                        std::span<const double> taus, const VsdOptions& options) {
  int seen_in_one = 0, seen_in_both = 0;
  std::vector<int> apart(taus.size(), 0);
  const auto compare = [&](int u, int v) {
    const float estimated_m = DistanceAt(estimated, u, v), true_m = DistanceAt(truth, u, v);
    const float measured_m = measured_distances_m(u, v);
    const bool true_seen = IsVisible(true_m, measured_m, options.delta_m);
    // Where the true pose is visible, the estimate is visible too, even behind the measured
    // surface.
    const bool estimate_seen =
        estimated_m > 0 && (true_seen || IsVisible(estimated_m, measured_m, options.delta_m));
    if (true_seen != estimate_seen) ++seen_in_one;
    if (!true_seen || !estimate_seen) return;
    ++seen_in_both;
    const double off_diameters = std::abs(true_m - estimated_m) / diameter_m;
    for (size_t i = 0; i < taus.size(); ++i) apart[i] += off_diameters >= taus[i];
  };
  const auto compare_all = [&](const DistanceCrop& silhouette, const auto& is_wanted) {
    for (int y = 0; y < silhouette.distances_m.height(); ++y) {
      for (int x = 0; x < silhouette.distances_m.width(); ++x) {
        if (silhouette.distances_m(x, y) <= 0) continue;
        const int u = x + silhouette.x, v = y + silhouette.y;
        if (is_wanted(u, v)) compare(u, v);
      }
    }
  };
  compare_all(truth, [](int, int) { return true; });
  compare_all(estimated, [&](int u, int v) { return DistanceAt(truth, u, v) <= 0; });
  const double all = seen_in_one + seen_in_both;
  std::vector<double> errors(taus.size(), 1.0);
  for (size_t i = 0; i < taus.size() && all > 0; ++i) errors[i] = (apart[i] + seen_in_one) / all;
  return errors;
}

}  // namespace pickbed::eval
