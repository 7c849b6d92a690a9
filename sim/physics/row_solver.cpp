#include "sim/physics/row_solver.h"

#include <cstring>

namespace pickbed::sim {
namespace {

// Inlined, so that a variant does not call code that was compiled for narrower vectors.
#define PICKBED_ROW_INLINE inline __attribute__((always_inline))

// The four numbers of a btVector3. The last one has no meaning. The compiler splits them if the
// processor has narrower registers.
using Four = btScalar __attribute__((vector_size(4 * sizeof(btScalar))));
static_assert(sizeof(btVector3) == sizeof(Four));

PICKBED_ROW_INLINE void Load(const btVector3& vector, Four& numbers) {
  std::memcpy(&numbers, vector.m_floats, sizeof(Four));
}
PICKBED_ROW_INLINE void Store(const Four& numbers, btVector3& vector) {
  std::memcpy(vector.m_floats, &numbers, sizeof(Four));
}

// btSolverBody::internalApplyImpulse() with the same order of products for each number.
PICKBED_ROW_INLINE void ApplyImpulse(btSolverBody& body, const btVector3& normal,
                                     const btVector3& angular_component, btScalar impulse) {
  if (body.m_originalBody == nullptr) return;
  Four linear, direction, inverse_mass, linear_factor;
  Load(body.m_deltaLinearVelocity, linear);
  Load(normal, direction);
  Load(body.m_invMass, inverse_mass);
  Load(body.m_linearFactor, linear_factor);
  const Four impulses = {impulse, impulse, impulse, impulse};
  linear += direction * inverse_mass * impulses * linear_factor;
  Store(linear, body.m_deltaLinearVelocity);
  Four angular, component, angular_factor;
  Load(body.m_deltaAngularVelocity, angular);
  Load(angular_component, component);
  Load(body.m_angularFactor, angular_factor);
  angular += component * (impulses * angular_factor);
  Store(angular, body.m_deltaAngularVelocity);
}

// Velocity of the body along the row that the solver has added so far. 0 for a fixed body.
btScalar AddedVelocity(const btSolverBody& body, const btVector3& linear,
                       const btVector3& angular) {
  if (body.m_originalBody == nullptr) return 0;
  return linear.dot(body.m_deltaLinearVelocity) + angular.dot(body.m_deltaAngularVelocity);
}

template <bool kHasUpperLimit>
PICKBED_ROW_INLINE btScalar SolveRow(btSolverBody& a, btSolverBody& b,
                                     const btSolverConstraint& row) {
  const btScalar applied = row.m_appliedImpulse;
  btScalar change = row.m_rhs - applied * row.m_cfm;
  change -= AddedVelocity(a, row.m_contactNormal1, row.m_relpos1CrossNormal) * row.m_jacDiagABInv;
  change -= AddedVelocity(b, row.m_contactNormal2, row.m_relpos2CrossNormal) * row.m_jacDiagABInv;
  btScalar impulse = applied + change;
  if (impulse < row.m_lowerLimit) {
    impulse = row.m_lowerLimit;
    change = impulse - applied;
  } else if (kHasUpperLimit && impulse > row.m_upperLimit) {
    impulse = row.m_upperLimit;
    change = impulse - applied;
  }
  if (change == 0) return 0;
  row.m_appliedImpulse = impulse;
  ApplyImpulse(a, row.m_contactNormal1, row.m_angularComponentA, change);
  ApplyImpulse(b, row.m_contactNormal2, row.m_angularComponentB, change);
  return change * (1 / row.m_jacDiagABInv);
}

}  // namespace

// Variants for AVX2 have no fused multiply-add, so that all variants round alike.
__attribute__((target_clones("avx2", "default"))) btScalar SolveLimitedRow(
    btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
  return SolveRow<true>(a, b, row);
}

__attribute__((target_clones("avx2", "default"))) btScalar SolveContactRow(
    btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
  return SolveRow<false>(a, b, row);
}

}  // namespace pickbed::sim
