// Rotation and translation error, each the least over the symmetries (without symmetries these are
// the BOP toolkit's re and te).

#include <algorithm>
#include <limits>

#include "eval/metrics.h"

namespace pickbed {

double RotationError(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    best = std::min(best, RotationAngleRad(X_est.linear(), (X_true * symmetry).linear()));
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
