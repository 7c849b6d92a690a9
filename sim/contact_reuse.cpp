#include "sim/contact_reuse_impl.h"

namespace pickbed {

void ReusingDispatcher::ForgetContacts() {
  for (int i = 0; i < getNumManifolds(); ++i) getManifoldByIndexInternal(i)->clearManifold();
}

bool ReusingDispatcher::HasMoved(const btCollisionObject& body) const {
  if (body.isStaticObject()) return false;
  const int index = body.getUserIndex();
  return index < 0 || moved.at(index);
}

void ReusingDispatcher::LookIfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                                    const btDispatcherInfo& info) {
  auto& self = static_cast<ReusingDispatcher&>(dispatcher);
  const auto* first = static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject);
  const auto* second = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
  // A pair without an algorithm is new: its boxes have just met.
  if (pair.m_algorithm == nullptr || self.HasMoved(*first) || self.HasMoved(*second)) {
    defaultNearCallback(pair, dispatcher, info);
    return;
  }
  if (!self.needsCollision(first, second)) return;  // both asleep
  self.manifolds_.resize(0);
  pair.m_algorithm->getAllContactManifolds(self.manifolds_);
  for (int i = 0; i < self.manifolds_.size(); ++i) {
    btPersistentManifold* manifold = self.manifolds_[i];
    manifold->refreshContactPoints(manifold->getBody0()->getWorldTransform(),
                                   manifold->getBody1()->getWorldTransform());
  }
}

}  // namespace pickbed
