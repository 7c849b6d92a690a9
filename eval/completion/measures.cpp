#include "eval/completion/measures.h"

#include <algorithm>
#include <cmath>

namespace pickbed::eval {
namespace {

constexpr float kTrueLevel = 0.5f;  // the truth is 0 or 1
constexpr int kBisections = 6;
// More points than this do not change the measures.
constexpr size_t kMaxPoints = 3000;
// True surface nearer to the seen surface than this is not hidden.
constexpr float kSeenMargin_m = 0.003f;

// Calls on_crossing(a, b, value_a, value_b) for each pair of neighboring cells on different sides
// of the level.
template <typename OnCrossing>
void ForCrossings(const CompletedVolume& volume, float level, const OnCrossing& on_crossing) {
  const int n = volume.size;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const float value = volume.occupancy[volume.Index(x, y, z)];
        for (int axis = 0; axis < 3; ++axis) {
          int next[3] = {x, y, z};
          if (++next[axis] == n) continue;
          const float beside = volume.occupancy[volume.Index(next[0], next[1], next[2])];
          if ((value > level) == (beside > level)) continue;
          on_crossing(volume.Center_C(x, y, z), volume.Center_C(next[0], next[1], next[2]), value,
                      beside);
        }
      }
    }
  }
}

std::vector<Eigen::Vector3f> Thinned(const std::vector<Eigen::Vector3f>& points) {
  const size_t stride = points.size() / kMaxPoints + 1;
  std::vector<Eigen::Vector3f> kept;
  for (size_t i = 0; i < points.size(); i += stride) kept.push_back(points[i]);
  return kept;
}

// Returns the distance of each point to the nearest of others, m.
std::vector<float> NearestDistances_m(const std::vector<Eigen::Vector3f>& points,
                                      const std::vector<Eigen::Vector3f>& others) {
  Eigen::Matrix3Xf columns(3, others.size());
  for (size_t i = 0; i < others.size(); ++i) columns.col(i) = others[i];
  std::vector<float> distances_m;
  distances_m.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    distances_m.push_back(std::sqrt((columns.colwise() - p).colwise().squaredNorm().minCoeff()));
  }
  return distances_m;
}

double ShareWithin(const std::vector<float>& distances_m, float limit_m) {
  if (distances_m.empty()) return 0;
  const auto count = std::count_if(distances_m.begin(), distances_m.end(),
                                   [&](float distance_m) { return distance_m <= limit_m; });
  return static_cast<double>(count) / static_cast<double>(distances_m.size());
}

double Mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return sum / static_cast<double>(std::max<size_t>(values.size(), 1));
}

bool IsHidden(const RandomView& drawn, const Eigen::Vector3f& p_C) {
  const SegmentView& view = drawn.view;
  const Eigen::Vector2d pixel = Project(view.intrinsics, p_C.cast<double>());
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  if (!view.segment.Contains(x, y) || !view.segment(x, y)) return true;
  return p_C.z() > view.depth_m(x, y) + kSeenMargin_m;
}

}  // namespace

std::vector<Eigen::Vector3f> SurfacePoints(const CompletedVolume& volume, float level) {
  std::vector<Eigen::Vector3f> points;
  ForCrossings(volume, level,
               [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b, float at_a, float at_b) {
                 points.push_back(a + (level - at_a) / (at_b - at_a) * (b - a));
               });
  return points;
}

std::vector<Eigen::Vector3f> TrueSurfacePoints(const ViewedSolid& solid, const RandomView& drawn,
                                               const CompletedVolume& truth) {
  const Eigen::Isometry3f X_OC = drawn.X_CO.inverse().cast<float>();
  std::vector<Eigen::Vector3f> in, out, centers_O;
  ForCrossings(truth, kTrueLevel,
               [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b, float at_a, float at_b) {
                 in.push_back(at_a > at_b ? a : b);
                 out.push_back(at_a > at_b ? b : a);
               });
  std::vector<uint8_t> inside(in.size());
  centers_O.resize(in.size());
  for (int step = 0; step < kBisections; ++step) {
    for (size_t i = 0; i < in.size(); ++i) centers_O[i] = X_OC * (0.5f * (in[i] + out[i]));
    solid.Inside(centers_O, inside);
    for (size_t i = 0; i < in.size(); ++i) {
      const Eigen::Vector3f center = 0.5f * (in[i] + out[i]);
      (inside[i] ? in[i] : out[i]) = center;
    }
  }
  for (size_t i = 0; i < in.size(); ++i) in[i] = 0.5f * (in[i] + out[i]);
  return in;
}

CompletionMeasures MeasureCompletion(const CompletedVolume& completed, const CompletedVolume& truth,
                                     const std::vector<Eigen::Vector3f>& surface,
                                     const RandomView& drawn, double diameter_m, float level) {
  CompletionMeasures measures;
  double both = 0, either = 0;
  for (size_t i = 0; i < truth.occupancy.size(); ++i) {
    const float p = completed.occupancy[i];
    const bool full = p > level, inside = truth.occupancy[i] > kTrueLevel;
    both += full && inside;
    either += full || inside;
    if (p <= 0) continue;
    auto& bin =
        measures
            .calibration[std::min(kCalibrationBins - 1, static_cast<int>(p * kCalibrationBins))];
    bin[0] += 1;
    bin[1] += p;
    bin[2] += inside;
  }
  measures.iou = either > 0 ? both / either : 1;
  const std::vector<Eigen::Vector3f> points = Thinned(SurfacePoints(completed, level));
  const std::vector<Eigen::Vector3f> true_points = Thinned(surface);
  measures.chamfer = 1;
  if (points.empty() || true_points.empty()) return measures;
  const std::vector<float> to_truth = NearestDistances_m(points, true_points);
  const std::vector<float> to_points = NearestDistances_m(true_points, points);
  measures.chamfer = 0.5 * (Mean(to_truth) + Mean(to_points)) / diameter_m;
  const float limit_m = kFScoreShare * static_cast<float>(diameter_m);
  const double precision = ShareWithin(to_truth, limit_m), recall = ShareWithin(to_points, limit_m);
  if (precision + recall > 0) measures.f_score = 2 * precision * recall / (precision + recall);
  std::vector<float> hidden_m;
  for (size_t i = 0; i < true_points.size(); ++i) {
    if (IsHidden(drawn, true_points[i])) hidden_m.push_back(to_points[i]);
  }
  measures.hidden_found = hidden_m.empty() ? 1 : ShareWithin(hidden_m, kHiddenTolerance_m);
  return measures;
}

}  // namespace pickbed::eval
