#include "perception/candidates/edge_comparison.h"

#include <algorithm>
#include <cmath>

#include "perception/verify/edge_support.h"

namespace pickbed::perception {
namespace {

constexpr double kPlaceDiameters = 0.3;  // poses further apart are of different instances
// Mean distance between the surfaces of compared poses, at most. Poses that differ by more also
// have different depth images, from which the verifier separates them better: of pairs of poses of
// a mug with a gap of 0.015 to 0.03, the edges favour the wrong pose in one of four.
constexpr double kMaxGapDiameters = 0.015;
constexpr double kSamePoseDiameters = 0.1;  // poses nearer than this are one
constexpr double kMinScore = 0.01;          // less likely candidates are no alternative
constexpr int kMinVisible = 40;             // edge points for a comparison
constexpr double kMaxVisibleDifference =
    0.15;  // between compared poses, share of the larger number

// Poses of one object at one place. Members of one pose have the same number.
struct Place {
  std::vector<size_t> candidates;
  std::vector<int> pose;
  int poses = 0;
};

// Mean distance from the surface of an object at X_CB to its surface at X_CA, in diameters.
double SurfaceGap(const ModelPoints& model, const Pose& X_CA, const Pose& X_CB) {
  constexpr size_t kPoints = 100;
  const Pose X_AB = X_CA.inverse() * X_CB;
  const size_t count = std::min(kPoints, model.points_O.size());
  double sum_m = 0;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p_A = X_AB * model.points_O[i].cast<double>();
    sum_m += std::min(model.diameter_m, model.distance.At(p_A.cast<float>()));
  }
  return sum_m / static_cast<double>(count) / model.diameter_m;
}

Place PlaceAround(size_t seed, const PoseDistance& distance, const ModelPoints& model,
                  const std::vector<Candidate>& candidates, const std::vector<size_t>& order,
                  std::vector<bool>& is_used) {
  const auto center_C = [&](size_t i) {
    return Eigen::Vector3d(candidates[i].hypothesis.X_CO * model.center_O.cast<double>());
  };
  Place place;
  std::vector<size_t> first_of_pose;
  for (const size_t i : order) {
    if (is_used[i] || candidates[i].hypothesis.object != candidates[seed].hypothesis.object ||
        (center_C(i) - center_C(seed)).norm() > kPlaceDiameters * distance.diameter_m() ||
        SurfaceGap(model, candidates[seed].hypothesis.X_CO, candidates[i].hypothesis.X_CO) >
            kMaxGapDiameters) {
      continue;
    }
    is_used[i] = true;
    const auto same = std::find_if(first_of_pose.begin(), first_of_pose.end(), [&](size_t other) {
      return distance(candidates[i].hypothesis.X_CO, candidates[other].hypothesis.X_CO) <
             kSamePoseDiameters;
    });
    place.candidates.push_back(i);
    place.pose.push_back(static_cast<int>(same - first_of_pose.begin()));
    if (same == first_of_pose.end()) first_of_pose.push_back(i);
  }
  place.poses = static_cast<int>(first_of_pose.size());
  return place;
}

// Fraction by which the support of candidate k is below the best one that shows about as many edge
// points. Poses that show other edges cannot be compared: a weak edge of the right pose would count
// against it.
double Below(const std::vector<EdgeSupport>& supports, size_t k) {
  const EdgeSupport& own = supports[k];
  if (own.visible < kMinVisible) return 0;
  double best = own.mean;
  for (const EdgeSupport& other : supports) {
    const int difference = std::abs(other.visible - own.visible);
    if (difference <= kMaxVisibleDifference * std::max(other.visible, own.visible)) {
      best = std::max(best, other.mean);
    }
  }
  return best > 0 ? 1 - own.mean / best : 0;
}

}  // namespace

void WeighByEdges(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
                  const std::vector<PoseDistance>& distances,
                  const std::vector<Candidate>& candidates, std::span<double> scores) {
  if (cloud.edges.empty()) return;
  std::vector<size_t> order;
  for (size_t i = 0; i < scores.size(); ++i) {
    if (scores[i] >= kMinScore) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return scores[a] > scores[b]; });
  std::vector<bool> is_used(scores.size());
  for (const size_t seed : order) {
    if (is_used[seed]) continue;
    const ObjectId object = candidates[seed].hypothesis.object;
    const Place place =
        PlaceAround(seed, distances[object], models[object], candidates, order, is_used);
    if (place.poses < 2) continue;
    std::vector<EdgeSupport> supports;
    for (const size_t i : place.candidates) {
      supports.push_back(MeasureEdgeSupport(cloud, models[object], candidates[i].hypothesis.X_CO));
    }
    // Likelihood of each candidate; of each pose the largest counts.
    std::vector<double> before(place.poses), after(place.poses), likely;
    for (size_t k = 0; k < place.candidates.size(); ++k) {
      const double score = scores[place.candidates[k]];
      likely.push_back(score * std::exp(-std::min(kMaxEdgeNats, kEdgeWeight * Below(supports, k))));
      before[place.pose[k]] = std::max(before[place.pose[k]], score);
      after[place.pose[k]] = std::max(after[place.pose[k]], likely.back());
    }
    double sum_before = 0, sum_after = 0;
    for (int pose = 0; pose < place.poses; ++pose) {
      sum_before += before[pose];
      sum_after += after[pose];
    }
    const double factor = std::min(1.0, sum_before) / sum_after;
    for (size_t k = 0; k < place.candidates.size(); ++k) {
      scores[place.candidates[k]] = factor * likely[k];
    }
  }
}

}  // namespace pickbed::perception
