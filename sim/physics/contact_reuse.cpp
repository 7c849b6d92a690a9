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

btPersistentManifold* ReusingDispatcher::getNewManifold(const btCollisionObject* first,
                                                        const btCollisionObject* second) {
  btPersistentManifold* manifold = btCollisionDispatcher::getNewManifold(first, second);
  if (manifold != nullptr) bodies_.emplace_back(first, second);
  return manifold;
}

// As in the base class, the last manifold takes the place of the released one.
void ReusingDispatcher::releaseManifold(btPersistentManifold* manifold) {
  bodies_.at(manifold->m_index1a) = bodies_.back();
  bodies_.pop_back();
  btCollisionDispatcher::releaseManifold(manifold);
}

int ReusingDispatcher::getNumManifolds() const {
  if (!only_awake_) return btCollisionDispatcher::getNumManifolds();
  awake_.clear();
  for (size_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i].first->getActivationState() == ISLAND_SLEEPING &&
        bodies_[i].second->getActivationState() == ISLAND_SLEEPING) {
      continue;
    }
    awake_.push_back(static_cast<int>(i));
  }
  return static_cast<int>(awake_.size());
}

btPersistentManifold* ReusingDispatcher::getManifoldByIndexInternal(int index) {
  return m_manifoldsPtr[only_awake_ ? awake_[index] : index];
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
  if (!first->isActive() && !second->isActive()) return;
  // A pair without an algorithm is new: its bounding boxes have just met.
  if (self.MustCheck(*first, *second) || pair.m_algorithm == nullptr) {
    defaultNearCallback(pair, dispatcher, info);
    return;
  }
  if (!self.needsCollision(first, second)) return;
  self.manifolds_.resize(0);
  pair.m_algorithm->getAllContactManifolds(self.manifolds_);
  for (int i = 0; i < self.manifolds_.size(); ++i) {
    btPersistentManifold* manifold = self.manifolds_[i];
    manifold->refreshContactPoints(manifold->getBody0()->getWorldTransform(),
                                   manifold->getBody1()->getWorldTransform());
  }
}

}  // namespace pickbed::sim
