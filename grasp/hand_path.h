#pragma once

// Straight paths of a hand: at rest at both ends, of least jerk between (Flash and Hogan 1985).

#include "scenes/pose.h"

namespace pickbed {

// The way that is done, 0..1, at a share 0..1 of the time.
double MinimumJerk(double t);

// How long such a path takes that reaches this speed in its middle.
double MinimumJerkSeconds(double distance_m, double peak_mps);

// Along the straight line and the shortest turn.
Pose Between(const Pose& from, const Pose& to, double share);

}  // namespace pickbed
