#pragma once

// Private to sim/physics: a Bullet world in which a moving body wakes only bodies that it touches.
//
// Bullet wakes all bodies that are connected through overlapping bounding boxes. In a pile, a
// finger near one instance then wakes all instances around it long before it touches one.

#include <btBulletDynamicsCommon.h>

namespace pickbed::sim {

// A world whose bodies sleep and wake in groups. A driven body of a hand, which has no user index,
// belongs to the group of an instance while it touches it.
class ContactIslandWorld : public btDiscreteDynamicsWorld {
 public:
  // If `by_contact` is false, bounding boxes also connect a hand to the groups, as in Bullet.
  ContactIslandWorld(btDispatcher& dispatcher, btBroadphaseInterface& broadphase,
                     btConstraintSolver& solver, btCollisionConfiguration& configuration,
                     bool by_contact);
};

}  // namespace pickbed::sim
