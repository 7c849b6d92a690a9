// Chance that a pick on the estimated pose fails, by the part's tolerance map (grasp/tolerance.h).

#include <limits>

#include "eval/metrics.h"
#include "grasp/tolerance.h"

namespace pickbed {

double PickRisk(const ToleranceModel* tolerance, const Pose& X_est, const Pose& X_true) {
  if (tolerance == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return 1 - SuccessProbability(*tolerance, X_true.inverse() * X_est);
}

}  // namespace pickbed
