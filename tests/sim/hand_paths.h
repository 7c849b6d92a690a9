#pragma once

// Paths of a hand in tests of physics.

#include <algorithm>
#include <cmath>

#include "sim/hand_joints.h"
#include "sim/physics_world.h"

namespace pickbed {

// A hand that points straight down.
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

// From where it is, with its orientation, along a straight line (Flash and Hogan 1985).
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

// From rest; the acceleration grows over the first 0.1 s, is then held, and the hand flies on.
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

}  // namespace pickbed
