#pragma once

// Contact constants: the pair rule of Coulomb friction and gravity.

namespace pickbed::scenes {

// Returns the Coulomb friction coefficient of two surfaces: the product of their values, as in
// Bullet. The value of an object is its friction against a gripper pad of value 1.
inline double PairFriction(double a, double b) { return a * b; }

// Standard gravity to three digits, used in physics and in planning.
inline constexpr double kGravity_mps2 = 9.81;

}  // namespace pickbed::scenes
