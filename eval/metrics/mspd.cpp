// Maximum Symmetry-Aware Projection Distance: as MSSD with distances between projections, in pixels
// (BOP 2020, eq. 4).

#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/metrics.h"

namespace pickbed {

double Mspd(const MetricModel& model, const CameraIntrinsics& camera, const Pose& X_est,
            const Pose& X_true) {
  std::vector<Eigen::Vector2d> estimated_px;
  estimated_px.reserve(model.vertices_O.size());
  for (const Eigen::Vector3d& v : model.vertices_O) {
    estimated_px.push_back(Project(camera, X_est * v));
  }
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    const Pose X = X_true * symmetry;
    double worst = 0;
    for (size_t i = 0; i < estimated_px.size() && worst < best; ++i) {
      const Eigen::Vector2d true_px = Project(camera, X * model.vertices_O[i]);
      worst = std::max(worst, (estimated_px[i] - true_px).squaredNorm());
    }
    best = std::min(best, worst);
  }
  return std::sqrt(best);
}

}  // namespace pickbed
