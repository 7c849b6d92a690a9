#include "grasp/place/hand_motion.h"

#include <algorithm>

namespace pickbed::grasp {
namespace {

constexpr double kAsideHeight_m = 0.12;

}  // namespace

double MinimumJerk(double t) { return t * t * t * (10 + t * (6 * t - 15)); }

double MinimumJerkSeconds(double distance_m, double peak_mps) {
  return 1.875 * distance_m / peak_mps;
}

Eigen::Vector3d LiftMotion(const Eigen::Vector2d& aside_m, double height_m) {
  const double left = 1 - std::min(1.0, height_m / kAsideHeight_m);
  const Eigen::Vector2d shift_m = (1 - left * left) * aside_m;
  return {shift_m.x(), shift_m.y(), height_m};
}

Pose Between(const Pose& from, const Pose& to, double share) {
  const Eigen::Quaterniond start(from.linear()), end(to.linear());
  return MakePose(start.slerp(share, end).toRotationMatrix(),
                  (1 - share) * from.translation() + share * to.translation());
}

}  // namespace pickbed::grasp
