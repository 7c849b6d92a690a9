// Maximum Symmetry-Aware Surface Distance: min over symmetries S of the largest
// |X_est v - X_true S v| over the vertices v (Drost et al. 2017; BOP 2020, eq. 3).

#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/metrics.h"

namespace pickbed {

double Mssd(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    // One matrix a vertex. (No inverse: published truth is not always orthonormal to all digits.)
    const Pose X_sym = X_true * symmetry;
    const Eigen::Matrix3d M = X_est.linear() - X_sym.linear();
    const Eigen::Vector3d t = X_est.translation() - X_sym.translation();
    double worst = 0;
    for (const Eigen::Vector3d& v : model.vertices_O) {
      worst = std::max(worst, (M * v + t).squaredNorm());
      if (worst >= best) break;  // this symmetry cannot win any more
    }
    best = std::min(best, worst);
  }
  return std::sqrt(best);
}

}  // namespace pickbed
