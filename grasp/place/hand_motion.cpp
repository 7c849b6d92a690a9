#include "grasp/place/hand_motion.h"

namespace pickbed::grasp {

double MinimumJerk(double t) { return t * t * t * (10 + t * (6 * t - 15)); }

double MinimumJerkSeconds(double distance_m, double peak_mps) {
  return 1.875 * distance_m / peak_mps;
}

Pose Between(const Pose& from, const Pose& to, double share) {
  const Eigen::Quaterniond start(from.linear()), end(to.linear());
  return MakePose(start.slerp(share, end).toRotationMatrix(),
                  (1 - share) * from.translation() + share * to.translation());
}

}  // namespace pickbed::grasp
