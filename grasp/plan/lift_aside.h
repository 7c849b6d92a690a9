#pragma once

// Sideways shift of a lift, which pulls a target out from under other instances.
//
// Lifted straight up, a target under others is wedged by them or carries them, and slips out of the
// hand. Pulled away from them at the start of the lift, it comes free more often. In deep bins of
// bottles, rods and gears, with true poses and others on top, 62 picks held and 11 slipped straight
// up. They were repeated with a path that was tilted by the same angle all the way. With 20
// degrees, 4 of the 11 held, and none of the others slipped. With 35 degrees, 5 held and 2 others
// slipped. The angle of the present path falls from 45 degrees or less to 0.

#include <Eigen/Core>
#include <span>

#include "grasp/layer.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"

namespace pickbed::grasp {

// Returns a shift (x, y) of this length away from `cover`, the center of what rests on the target.
// Zero if it is so close to the target's center of mass that no direction is better.
Eigen::Vector2d AwayFrom(const Eigen::Vector2d& cover, const Eigen::Vector2d& center_of_mass,
                         double length_m);

// Returns the part of the shift (x, y) in the frame of the bin that keeps target and hand 1 cm away
// from the walls. `target_B` are points of the target, one per column. `boxes_G` are the hand's
// boxes at X_BG. Points and boxes above the rim meet no wall.
Eigen::Vector2d ShiftInBin(const Eigen::Vector2d& shift_m, const Bin& bin,
                           const Eigen::Matrix3Xd& target_B,
                           std::span<const AxisAlignedBox> boxes_G, const Pose& X_BG);

}  // namespace pickbed::grasp
