#pragma once

// Paths of a hand in physics tests.

#include <algorithm>
#include <cmath>

#include "sim/hands/jaw_hand.h"
#include "sim/physics/physics_world.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Returns the pose of a hand at p_W that points straight down (z of G = -z of W).
inline Pose HandOver(const Eigen::Vector3d& p_W) {
  return MakePose(Eigen::Vector3d(1, -1, -1).asDiagonal(), p_W);
}

inline void Stay(PhysicsWorld& world, Hand& hand, const Pose& X_WG, double duration_s) {
  const long steps = std::lround(duration_s / world.step_s());
  for (long i = 0; i < steps; ++i) {
    hand.MoveTo(X_WG);
    world.Step();
  }
}

// Moves the hand from its pose to `to` along a straight line with minimum jerk (Flash and Hogan
// 1985). The orientation is the orientation of `to`.
inline void MoveAlongMinimumJerk(PhysicsWorld& world, Hand& hand, const Pose& to,
                                 double duration_s) {
  const Pose from = hand.X_WG();
  const long steps = std::lround(duration_s / world.step_s());
  for (long i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(steps);
    const double s = t * t * t * (10 - 15 * t + 6 * t * t);
    Pose now = to;
    now.translation() = (1 - s) * from.translation() + s * to.translation();
    hand.MoveTo(now);
    world.Step();
  }
}

// Accelerates the hand from rest. The acceleration rises linearly over the first 0.1 s and is then
// held for `held_s`.
inline void AccelerateFor(PhysicsWorld& world, Hand& hand, const Eigen::Vector3d& a_W,
                          double held_s) {
  constexpr double kRamp_s = 0.1;
  const double dt = world.step_s();
  Pose now = hand.X_WG();
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();
  const long steps = std::lround((kRamp_s + held_s) / dt);
  for (long i = 1; i <= steps; ++i) {
    v_W += std::min(1.0, static_cast<double>(i) * dt / kRamp_s) * dt * a_W;
    now.translation() += dt * v_W;
    hand.MoveTo(now);
    world.Step();
  }
}

}  // namespace pickbed::tests
