#include "sim/physics/contact_islands.h"

#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>

#include <new>

namespace pickbed::sim {
namespace {

class ContactIslands : public btSimulationIslandManager {
 public:
  // Called in each step after the contact search. Joints are added to the groups afterwards.
  void updateActivationState(btCollisionWorld* world, btDispatcher*) override {
    int count = 0;
    btCollisionObjectArray& bodies = world->getCollisionObjectArray();
    for (int i = 0; i < bodies.size(); ++i) {
      if (!bodies[i]->isStaticOrKinematicObject()) bodies[i]->setIslandTag(count++);
      bodies[i]->setCompanionId(-1);
      bodies[i]->setHitFraction(1);
    }
    initUnionFind(count);
    btOverlappingPairCache& pairs = *world->getPairCache();
    for (int i = 0; i < pairs.getNumOverlappingPairs(); ++i) {
      const btBroadphasePair& pair = pairs.getOverlappingPairArrayPtr()[i];
      const auto* a = static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject);
      const auto* b = static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject);
      if (!a->mergesSimulationIslands() || !b->mergesSimulationIslands()) continue;
      const bool has_hand = a->getUserIndex() < 0 || b->getUserIndex() < 0;
      if (has_hand && !Touch(pair)) continue;
      getUnionFind().unite(a->getIslandTag(), b->getIslandTag());
    }
  }

 private:
  bool Touch(const btBroadphasePair& pair) {
    if (pair.m_algorithm == nullptr) return false;
    manifolds_.resize(0);
    pair.m_algorithm->getAllContactManifolds(manifolds_);
    for (int i = 0; i < manifolds_.size(); ++i) {
      if (manifolds_[i]->getNumContacts() > 0) return true;
    }
    return false;
  }

  btManifoldArray manifolds_;  // of one pair; a member to reuse its memory
};

}  // namespace

ContactIslandWorld::ContactIslandWorld(btDispatcher& dispatcher, btBroadphaseInterface& broadphase,
                                       btConstraintSolver& solver,
                                       btCollisionConfiguration& configuration, bool by_contact)
    : btDiscreteDynamicsWorld(&dispatcher, &broadphase, &solver, &configuration) {
  if (!by_contact) return;
  // The base class deletes the manager in this way.
  m_islandManager->~btSimulationIslandManager();
  btAlignedFree(m_islandManager);
  m_islandManager =
      new (btAlignedAlloc(sizeof(ContactIslands), alignof(ContactIslands))) ContactIslands();
}

}  // namespace pickbed::sim
