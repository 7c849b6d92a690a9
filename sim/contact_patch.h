#pragma once

// Flat patches of contact: outline, and the arm of even pressure.

#include <Eigen/Core>
#include <vector>

namespace pickbed {

// Counter-clockwise, without points on its sides (Andrew 1979, monotone chain).
std::vector<Eigen::Vector2d> ConvexOutline(std::vector<Eigen::Vector2d> points);

// Part of a convex outline within |x| <= half.x, |y| <= half.y (Sutherland and Hodgman 1974).
std::vector<Eigen::Vector2d> ClippedToRectangle(std::vector<Eigen::Vector2d> outline,
                                                const Eigen::Vector2d& half);

struct EvenPressure {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  // Mean distance of the patch's points from there: friction's torque is mu * F times this.
  double arm = 0;
};

// Of a convex outline with even pressure; a line's (its middle, length / 4) or a point's (arm 0)
// when it has no area. `outline` must not be empty.
EvenPressure PressureOn(const std::vector<Eigen::Vector2d>& outline);

}  // namespace pickbed
