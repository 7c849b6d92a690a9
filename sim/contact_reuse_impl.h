#pragma once

// Private to sim's physics: a Bullet dispatcher that need not look for contacts in every step.
//
// Most of a pile's time went into finding the contacts of parts that had hardly moved. A
// pair of bodies of which neither has moved since its last full look keeps its contact points; only
// their depths are brought up to date, as Bullet does itself before it looks for new ones.

#include <btBulletDynamicsCommon.h>

#include <vector>

namespace pickbed {

class ReusingDispatcher : public btCollisionDispatcher {
 public:
  explicit ReusingDispatcher(btCollisionConfiguration* configuration)
      : btCollisionDispatcher(configuration) {}

  // From the next step on; without it, every pair is looked at in full.
  void StartReuse() { setNearCallback(LookIfMoved); }

  // Back to a full look in every step. Also forgets all contacts found so far, and with them
  // friction's anchors and the solver's first guess.
  void StopReuse();

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
