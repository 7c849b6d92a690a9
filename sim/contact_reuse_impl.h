#pragma once

// Private to sim's physics: a Bullet dispatcher that need not look for contacts in every step.
//
// A pair of bodies of which neither has moved since its last full look keeps its contact points;
// only their depths are brought up to date, as Bullet does itself before it looks for new ones.
// That saves most of a pile's time, and it holds the pile: a full look often finds another closest
// point on the same two faces and puts it in the place of an old one, whose friction is then
// forgotten, so that parts at rest creep by millimetres a second.

#include <btBulletDynamicsCommon.h>

#include <vector>

namespace pickbed {

class ReusingDispatcher : public btCollisionDispatcher {
 public:
  explicit ReusingDispatcher(btCollisionConfiguration* configuration)
      : btCollisionDispatcher(configuration) {}

  // From the next step on; without it, every pair is looked at in full.
  void StartReuse() { setNearCallback(LookIfMoved); }

  // Also friction's anchors and the solver's first guess. Say of all bodies that they moved.
  void ForgetContacts();

  // By body user index, set before each step: whether that body has moved since the last step in
  // which this was said of it. Moving bodies without an index are always looked at in full.
  std::vector<bool> moved;

 private:
  static void LookIfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                          const btDispatcherInfo& info);
  bool HasMoved(const btCollisionObject& body) const;

  btManifoldArray manifolds_;  // of one pair; kept for its memory
};

}  // namespace pickbed
