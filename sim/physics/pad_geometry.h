#pragma once

// Geometry of flat contact patches on finger pads: outline, lever arm of uniform pressure, and the
// contacts of a whole pad face.

#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <vector>

#include "sim/layer.h"

namespace pickbed::sim {

// Returns the convex hull, counter-clockwise, without points on its sides (Andrew 1979, monotone
// chain).
std::vector<Eigen::Vector2d> ConvexOutline(std::vector<Eigen::Vector2d> points);

// Returns the part of a convex outline within |x| <= half.x and |y| <= half.y (Sutherland and
// Hodgman 1974).
std::vector<Eigen::Vector2d> ClippedToRectangle(std::vector<Eigen::Vector2d> outline,
                                                const Eigen::Vector2d& half);

// A patch with uniform pressure, reduced to its center and friction lever arm.
struct EvenPressure {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  // Mean distance of the patch's points to `center`. The friction torque is mu * F * arm.
  double arm = 0;
};

// Computes center and arm of a convex outline with uniform pressure. An outline without area gives
// the values of a line (center, length / 4) or a point (arm 0). `outline` must not be empty.
EvenPressure PressureOn(const std::vector<Eigen::Vector2d>& outline);

// Returns true for a finger of a jaw. Its faces perpendicular to x are pads.
bool IsPad(const btCollisionObjectWrapper& body);

// Adds contacts for the whole face of `hull` on the pad: its corners after clipping to the pad's
// edges. `axis_W` is parallel to the line between the two bodies, with any length. Adds nothing if
// they do not meet face to face. Units are Bullet's.
// Reason: Bullet finds one contact point of two pieces per step, anywhere on the common area of two
// flat faces. It collects up to four over several steps. Until then, closing fingers press at two
// places that are not opposite. Objects were then rotated out of the hand, or pads sank into them
// by millimetres, depending on the first steps.
void AddPadFace(const btCollisionObjectWrapper& pad, const btCollisionObjectWrapper& hull,
                bool pad_is_first, const btVector3& axis_W, btManifoldResult& result);

}  // namespace pickbed::sim
