#pragma once

// Private to sim/hands: contact forces on a hand, read from Bullet's last step.

#include <vector>

#include "scenes/geometry/pose.h"
#include "sim/hands/hand.h"

class btCollisionObject;
class btCollisionWorld;
class btPersistentManifold;

namespace pickbed::sim {

// An instance touches the hand from this force on.
inline constexpr double kTouch_n = 0.01;

// Contacts of a body of the hand with one convex piece of another body.
struct BodyContacts {
  const btPersistentManifold* manifold = nullptr;
  const btCollisionObject* other = nullptr;
};

// Returns all contacts of a body. Only the manifolds of its own pairs are read: a pile has
// thousands of others.
std::vector<BodyContacts> ContactsOf(const btCollisionObject& body, btCollisionWorld& world);

// Returns the sum over the contacts, N.
double NormalForce_n(const btPersistentManifold& manifold, double step_s);

// Adds normal forces and friction on the hand to `load`. The hand is the manifold's first or second
// body.
void AddContactForces(const btPersistentManifold& manifold, bool hand_is_first, const Pose& X_WG,
                      double step_s, HandLoad& load);

}  // namespace pickbed::sim
