#pragma once

// Private to sim's physics: what Bullet's contacts of the last step say of a hand.

#include "scenes/pose.h"
#include "sim/hand_joints.h"

class btCollisionObject;
class btPersistentManifold;

namespace pickbed {

// What `body` touches there; null when the contacts are not its own.
const btCollisionObject* OtherBody(const btPersistentManifold& manifold,
                                   const btCollisionObject& body);

// Sum over the contacts, N.
double NormalForce_n(const btPersistentManifold& manifold, double step_s);

// Normal forces and friction on the hand at X_WG, whose body is the first of the two or the second.
void AddContactForces(const btPersistentManifold& manifold, bool hand_is_first, const Pose& X_WG,
                      double step_s, HandLoad& load);

}  // namespace pickbed
