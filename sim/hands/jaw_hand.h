#pragma once

// Parallel-jaw hand: a palm that follows a path, and two coupled fingers on sliders with a force
// limit.
//
// The palm is kinematic. The fingers are on 6-dof constraints with a force-limited motor and one
// coupling row. Their holding force is within 5 % of the analytic limit 2*mu*F = m*(g+a).
//
// Along the approach each finger rests on a stop with an overload slide, like the collision
// protection of real hands. It is rigid against a pull and yields to a push at a set force. Without
// the slide, the solver would determine the force of an impact, and it grew with the step rate.

#include <Eigen/Core>
#include <vector>

#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"
#include "sim/hands/hand.h"
#include "sim/physics/physics_world.h"

namespace pickbed::sim {

// Dimensions and limits of the hand. Frame G: z approach, x closing. The origin is midway between
// the pads at the ends of the finger tips. So the tips end at z = 0 and the palm is at negative z.
//
//      +---------------+
//      |     palm      |
//      +--+--+---+--+--+
//         |  |   |  |
//   left  |  |   |  |  right finger
//         +--+ G +--+ ---> x (closing)
//              |
//              v z (approach)
struct HandSpec {
  Eigen::Vector3d finger_size_m{0.010, 0.020, 0.050};  // x thickness, y width, z length
  Eigen::Vector3d palm_size_m{0.10, 0.04, 0.03};       // box behind the fingers
  double stroke_m = 0.08;                              // largest opening between the pads
  double finger_mass_kg = 0.2;
  double force_n = 40;           // force of each finger on the object
  double close_speed_mps = 0.1;  // speed of each finger
  double pad_friction = 1.0;     // the pad's value in the pair rule of scenes/objects/contact.h
  double yield_n = 40;           // push against the approach at which a finger yields
};

// Adds the hand to the world, which owns it, with the fingers open by the stroke. Throws
// std::logic_error if the world has a hand already.
Hand& AddJawHand(PhysicsWorld& world, const HandSpec& spec, const Pose& X_WG);

// Returns the hand's boxes (left finger, right finger, palm) in G at an opening, for collision
// checks.
std::vector<AxisAlignedBox> HandBoxes(const HandSpec& spec, double opening_m);

}  // namespace pickbed::sim
