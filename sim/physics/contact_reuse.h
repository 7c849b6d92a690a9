#pragma once

// Private to sim/physics: a Bullet dispatcher that reuses contact points of bodies that do not
// move.
//
// A pair keeps its contact points while neither body has moved since its last contact search. Only
// the depths are updated, as Bullet does itself before each search. This saves most of the time of
// a clutter scene.
//
// It also keeps the scene at rest. A search often finds another closest point on the same two
// faces. It replaces an old point, and the friction anchor of that point is lost. Bodies at rest
// then creep by millimetres per second.
//
// The same rule holds for a hand's body and an instance that have not moved relative to each other.
// So contacts are searched while an instance is grasped, but not while it is carried.
//
// Bullet visits all manifolds (the contacts of two convex pieces) in each step, to find the ones of
// awake bodies. Around a grasp nearly all are of sleeping ones. The dispatcher therefore keeps the
// bodies of all manifolds in one small array, and shows only the manifolds of awake bodies.

#include <btBulletDynamicsCommon.h>

#include <map>
#include <utility>
#include <vector>

#include "sim/layer.h"

namespace pickbed::sim {

// Returns an upper bound of the movement of any point within `radius` of the origin between two
// poses.
btScalar Movement(const btTransform& from, const btTransform& to, btScalar radius);

// Dispatcher that searches contacts only for pairs that have moved.
class ReusingDispatcher : public btCollisionDispatcher {
 public:
  explicit ReusingDispatcher(btCollisionConfiguration* configuration)
      : btCollisionDispatcher(configuration) {}

  // Starts the reuse with the next step; before that, all pairs are searched. A hand and an
  // instance may move relative to each other by `still` (in Bullet's units) without a new search.
  void StartReuse(btScalar still);

  // Also deletes friction anchors and the solver's initial impulses. The caller must set `moved` to
  // true for all bodies.
  void ForgetContacts();

  // While it is true, the manifolds of this dispatcher are only those with an awake body.
  void ShowOnlyAwake(bool only_awake) { only_awake_ = only_awake; }

  btPersistentManifold* getNewManifold(const btCollisionObject* first,
                                       const btCollisionObject* second) override;
  void releaseManifold(btPersistentManifold* manifold) override;
  // Bullet asks for the number before it visits the manifolds, so this finds the awake ones.
  int getNumManifolds() const override;
  btPersistentManifold* getManifoldByIndexInternal(int index) override;

  // Whether a body has moved since the last step in which its entry was true. Indexed by body user
  // index; set before each step. Moving bodies without an index are a hand's.
  std::vector<bool> moved;
  std::vector<btScalar> radius;  // radius of each instance about its center, by the same index

 private:
  static void CheckIfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                           const btDispatcherInfo& info);
  bool MustCheck(const btCollisionObject& first, const btCollisionObject& second);
  bool HasMoved(const btCollisionObject& body) const;

  btScalar still_ = 0;
  // Pose of the second body in the frame of the first at their last contact search.
  std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, btTransform> checked_;
  btManifoldArray manifolds_;  // of one pair; a member to reuse its memory
  // Bodies of m_manifoldsPtr, by the same index.
  std::vector<std::pair<const btCollisionObject*, const btCollisionObject*>> bodies_;
  bool only_awake_ = false;
  mutable std::vector<int> awake_;  // indices into m_manifoldsPtr
};

}  // namespace pickbed::sim
