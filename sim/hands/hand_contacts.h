#pragma once

// Private to sim/hands: contact forces on a hand, read from Bullet's last step.

#include "scenes/geometry/pose.h"
#include "sim/hands/hand.h"

class btCollisionObject;
class btPersistentManifold;

namespace pickbed::sim {

// An instance touches the hand from this force on.
inline constexpr double kTouch_n = 0.01;

// Returns the body that touches `body` in this manifold, or null if `body` is not part of it.
const btCollisionObject* OtherBody(const btPersistentManifold& manifold,
                                   const btCollisionObject& body);

// Returns the sum over the contacts, N.
double NormalForce_n(const btPersistentManifold& manifold, double step_s);

// Adds normal forces and friction on the hand to `load`. The hand is the manifold's first or second
// body.
void AddContactForces(const btPersistentManifold& manifold, bool hand_is_first, const Pose& X_WG,
                      double step_s, HandLoad& load);

}  // namespace pickbed::sim
