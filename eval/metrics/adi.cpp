// Average Distance to the closest model point (Hinterstoisser et al. 2012): for each vertex at the
// truth, the nearest vertex at the estimate, as the BOP toolkit computes it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/metrics.h"

namespace pickbed {
namespace {

// Nearest distance by a sweep outwards in x from the query, over points sorted by x.
double NearestDistance(const std::vector<Eigen::Vector3d>& sorted, const Eigen::Vector3d& p) {
  const auto by_x = [](const Eigen::Vector3d& a, double x) { return a.x() < x; };
  const auto start = std::lower_bound(sorted.begin(), sorted.end(), p.x(), by_x);
  double best = std::numeric_limits<double>::infinity();
  for (auto it = start; it != sorted.end(); ++it) {
    const double dx = it->x() - p.x();
    if (dx * dx >= best) break;
    best = std::min(best, (*it - p).squaredNorm());
  }
  for (auto it = start; it != sorted.begin();) {
    --it;
    const double dx = it->x() - p.x();
    if (dx * dx >= best) break;
    best = std::min(best, (*it - p).squaredNorm());
  }
  return std::sqrt(best);
}

}  // namespace

double Adi(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  std::vector<Eigen::Vector3d> estimate;
  estimate.reserve(model.vertices_O.size());
  for (const Eigen::Vector3d& v : model.vertices_O) estimate.push_back(X_est * v);
  std::sort(estimate.begin(), estimate.end(),
            [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.x() < b.x(); });
  double sum = 0;
  for (const Eigen::Vector3d& v : model.vertices_O) sum += NearestDistance(estimate, X_true * v);
  return sum / static_cast<double>(model.vertices_O.size());
}

}  // namespace pickbed
