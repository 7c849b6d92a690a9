#include "sim/hands/hand_contacts.h"

#include <btBulletDynamicsCommon.h>

#include "sim/physics/bullet_types.h"

namespace pickbed::sim {

std::vector<BodyContacts> ContactsOf(const btCollisionObject& body, btCollisionWorld& world) {
  std::vector<BodyContacts> contacts;
  btManifoldArray manifolds;
  btOverlappingPairCache& pairs = *world.getPairCache();
  const int count = pairs.getNumOverlappingPairs();
  const btBroadphasePair* const all = pairs.getOverlappingPairArrayPtr();
  const btBroadphaseProxy* const proxy = body.getBroadphaseHandle();
  for (int i = 0; i < count; ++i) {
    const btBroadphasePair& pair = all[i];
    if ((pair.m_pProxy0 != proxy && pair.m_pProxy1 != proxy) || pair.m_algorithm == nullptr) {
      continue;
    }
    const btBroadphaseProxy& its = pair.m_pProxy0 == proxy ? *pair.m_pProxy1 : *pair.m_pProxy0;
    const auto* other = static_cast<const btCollisionObject*>(its.m_clientObject);
    manifolds.resize(0);
    pair.m_algorithm->getAllContactManifolds(manifolds);
    for (int m = 0; m < manifolds.size(); ++m) {
      if (manifolds[m]->getNumContacts() > 0) contacts.push_back({manifolds[m], other});
    }
  }
  return contacts;
}

double NormalForce_n(const btPersistentManifold& manifold, double step_s) {
  double impulse = 0;
  for (int k = 0; k < manifold.getNumContacts(); ++k) {
    impulse += manifold.getContactPoint(k).getAppliedImpulse();
  }
  return impulse / (step_s * kUnitsPerMeter);
}

// Bullet's impulses act on the first body, along the normal and two friction directions.
void AddContactForces(const btPersistentManifold& manifold, bool hand_is_first, const Pose& X_WG,
                      double step_s, HandLoad& load) {
  const double sign = hand_is_first ? 1 : -1;
  const Eigen::Matrix3d R_GW = X_WG.linear().transpose();
  for (int k = 0; k < manifold.getNumContacts(); ++k) {
    const btManifoldPoint& point = manifold.getContactPoint(k);
    const btVector3 impulse = point.m_appliedImpulse * point.m_normalWorldOnB +
                              point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
                              point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
    const Eigen::Vector3d force_n = R_GW * FromBullet(sign / step_s * impulse);
    const Eigen::Vector3d at_G = X_WG.inverse() * FromBullet(point.getPositionWorldOnB());
    load.force_n += force_n;
    load.torque_nm += at_G.cross(force_n);
  }
}

}  // namespace pickbed::sim
