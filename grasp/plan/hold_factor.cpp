#include "grasp/plan/hold_factor.h"

namespace pickbed::grasp {

double HoldFactor(const Gripper& gripper, const ObjectModel& object, const Pose& X_OG,
                  const Pose& X_WO, double lift_load) {
  const Pose X_GO = X_OG.inverse();
  const Eigen::Vector3d down_G = -(X_GO.linear() * X_WO.linear().transpose()).col(2);
  const double share = lift_load * gripper.WeightShare(object, X_GO, down_G);
  // The fourth power separates the two sides of the limit, without a jump that rounding could move.
  const double square = share * share;
  return 1 / (1 + square * square);
}

}  // namespace pickbed::grasp
