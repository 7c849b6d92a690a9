// Rotation and translation error, each the least over the symmetries (without symmetries these are
// the BOP toolkit's re and te).

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/metrics.h"

namespace pickbed {

double RotationError(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    const Eigen::Matrix3d R_true = (X_true * symmetry).linear();
    // The toolkit's own formula, which matters where published truth is not quite orthonormal.
    const double cosine = 0.5 * ((X_est.linear() * R_true.inverse()).trace() - 1);
    best = std::min(best, std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  return best;
}

double TranslationError(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    const Eigen::Vector3d truth = X_true * symmetry.translation();
    best = std::min(best, (X_est.translation() - truth).norm());
  }
  return best;
}

}  // namespace pickbed
