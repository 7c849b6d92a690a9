#include "sim/physics/contact_reuse.h"

#include <cmath>

namespace pickbed::sim {

btScalar Movement(const btTransform& from, const btTransform& to, btScalar radius) {
  btScalar squared_turn = 0;  // Frobenius norm of the rotations' difference
  for (int row = 0; row < 3; ++row) {
    squared_turn += (from.getBasis()[row] - to.getBasis()[row]).length2();
  }
  return from.getOrigin().distance(to.getOrigin()) + radius * std::sqrt(squared_turn);
}

void ReusingDispatcher::StartReuse(btScalar still) {
  still_ = still;
  setNearCallback(CheckIfMoved);
}

void ReusingDispatcher::ForgetContacts() {
  checked_.clear();
  for (int i = 0; i < getNumManifolds(); ++i) getManifoldByIndexInternal(i)->clearManifold();
}

bool ReusingDispatcher::HasMoved(const btCollisionObject& body) const {
  if (body.isStaticObject()) return false;
  return moved.at(body.getUserIndex());
}

bool ReusingDispatcher::MustCheck(const btCollisionObject& first, const btCollisionObject& second) {
  const bool first_is_hand = first.getUserIndex() < 0 && !first.isStaticObject();
  const bool second_is_hand = second.getUserIndex() < 0 && !second.isStaticObject();
  if (!first_is_hand && !second_is_hand) return HasMoved(first) || HasMoved(second);
  const int index = first_is_hand ? second.getUserIndex() : first.getUserIndex();
  if (index < 0) return true;
  const btTransform now = first.getWorldTransform().inverseTimes(second.getWorldTransform());
  const auto [entry, is_new] = checked_.try_emplace({&first, &second}, now);
  if (!is_new && Movement(entry->second, now, radius.at(index)) <= still_) return false;
  entry->second = now;
  return true;
}

void ReusingDispatcher::CheckIfMoved(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                                     const btDispatcherInfo& info) {
  auto& self = static_cast<ReusingDispatcher&>(dispatcher);
  const auto* first = static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject);
  const auto* second = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
  // A pair without an algorithm is new: its bounding boxes have just met.
  if (self.MustCheck(*first, *second) || pair.m_algorithm == nullptr) {
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

}  // namespace pickbed::sim
