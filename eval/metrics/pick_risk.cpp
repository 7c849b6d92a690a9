// Pick risk from the tolerance model of an object (grasp/tolerance/tolerance_model.h).

#include <limits>

#include "eval/metrics/pose_errors.h"
#include "grasp/tolerance/tolerance_model.h"

namespace pickbed::eval {

double PickRisk(const ToleranceModel* tolerance, const Pose& X_est, const Pose& X_true) {
  if (tolerance == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return 1 - SuccessProbability(*tolerance, X_true.inverse() * X_est);
}

}  // namespace pickbed::eval
