#include "sim/physics/row_solver.h"

namespace pickbed::sim {
namespace {

// Velocity of the body along the row that the solver has added so far. 0 for a fixed body.
btScalar AddedVelocity(const btSolverBody& body, const btVector3& linear,
                       const btVector3& angular) {
  if (body.m_originalBody == nullptr) return 0;
  return linear.dot(body.m_deltaLinearVelocity) + angular.dot(body.m_deltaAngularVelocity);
}

template <bool kHasUpperLimit>
btScalar SolveRow(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
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
  a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA,
                         change);
  b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB,
                         change);
  return change * (1 / row.m_jacDiagABInv);
}

}  // namespace

btScalar SolveLimitedRow(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
  return SolveRow<true>(a, b, row);
}

btScalar SolveContactRow(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row) {
  return SolveRow<false>(a, b, row);
}

}  // namespace pickbed::sim
