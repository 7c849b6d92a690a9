#pragma once

// The one pair rule of Coulomb friction: the coefficients of the two surfaces multiply (as Bullet
// does). A part's own value is its friction against a gripper pad of value 1.

namespace pickbed {

inline constexpr double kPadFriction = 1.0;

inline double PairFriction(double a, double b) { return a * b; }

}  // namespace pickbed
