#pragma once

// Private to sim's physics: a Bullet dispatcher that need not look for contacts in every step.
//
// A pair of bodies of which neither has moved since its last full look keeps its contact points;
// only their depths are brought up to date, as Bullet does itself before it looks for new ones.
// That saves most of a pile's time, and it holds the pile: a full look often finds another closest
// point on the same two faces and puts it in the place of an old one, whose friction is then
// forgotten, so that parts at rest creep by millimetres a second. Likewise a hand's body and a part
// that have not moved against each other: what is held is looked at while it is taken, and not
// while it is carried.

#include <btBulletDynamicsCommon.h>

#include <map>
#include <utility>
#include <vector>

namespace pickbed {

// Bound on how far any point within `radius` of the origin moves from one pose to the other.
btScalar Movement(const btTransform& from, const btTransform& to, btScalar radius);

class ReusingDispatcher : public btCollisionDispatcher {
 public:
  explicit ReusingDispatcher(btCollisionConfiguration* configuration)
      : btCollisionDispatcher(configuration) {}

  // From the next step on; without it, every pair is looked at in full. Hand and part may move
  // against each other by `still`, in Bullet's units.
  void StartReuse(btScalar still);

  // Also friction's anchors and the solver's first guess. Say of all bodies that they moved.
  void ForgetContacts();

  // By body user index, set before each step: whether that body has moved since the last step in
  // which this was said of it. Moving bodies without an index are a hand's.
  std::vector<bool> moved;
  std::vector<btScalar> radius;  // of the parts about their centres, by the same index

 private:
  static void LookIfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                          const btDispatcherInfo& info);
  bool MustLook(const btCollisionObject& first, const btCollisionObject& second);
  bool HasMoved(const btCollisionObject& body) const;

  btScalar still_ = 0;
  // Pose of the second body in the first's frame when they were last looked at.
  std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, btTransform> looked_;
  btManifoldArray manifolds_;  // of one pair; kept for its memory
};

}  // namespace pickbed
