#pragma once

namespace pickbed {

// Standard gravity to three digits: what parts weigh, in physics and in planning.
inline constexpr double kGravity_mps2 = 9.81;

}  // namespace pickbed
