// Average Distance of model points (Hinterstoisser et al. 2012), for parts without symmetry.

#include "eval/metrics.h"

namespace pickbed {

double Add(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double sum = 0;
  for (const Eigen::Vector3d& v : model.vertices_O) sum += (X_est * v - X_true * v).norm();
  return sum / static_cast<double>(model.vertices_O.size());
}

}  // namespace pickbed
