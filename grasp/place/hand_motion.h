#pragma once

// Straight motions of a hand with minimum jerk, at rest at both ends (Flash and Hogan 1985).

#include "grasp/layer.h"
#include "scenes/geometry/pose.h"

namespace pickbed::grasp {

// Share 0..1 of the path that is done at share `t` 0..1 of the time.
double MinimumJerk(double t);

// Duration in s of a minimum-jerk motion whose peak speed is `peak_mps`.
double MinimumJerkSeconds(double distance_m, double peak_mps);

// Returns the hand's motion from the start of a lift to this height, in W. The shift `aside_m` is
// complete at a height of 12 cm. It is quick at first, to pull an object out from under others, and
// slows down steadily, so that nothing jerks.
Eigen::Vector3d LiftMotion(const Eigen::Vector2d& aside_m, double height_m);

// Interpolates position linearly and orientation along the shortest rotation; `share` in 0..1.
Pose Between(const Pose& from, const Pose& to, double share);

}  // namespace pickbed::grasp
