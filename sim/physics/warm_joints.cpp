#include "sim/physics/warm_joints.h"

#include <algorithm>
#include <utility>

#include "sim/physics/row_solver.h"

namespace pickbed::sim {

void WarmJointSolver::BeginStep() {
  last_ = std::move(now_);
  now_.clear();
}

template <typename Visit>
void WarmJointSolver::ForEachJoint(const Visit& visit) {
  btConstraintArray& rows = m_tmpSolverNonContactConstraintPool;
  for (int first = 0, end = 0; first < rows.size(); first = end) {
    const void* joint = rows[first].m_originalContactPoint;  // Bullet keeps the joint here
    while (end < rows.size() && rows[end].m_originalContactPoint == joint) ++end;
    visit(joint, first, end);
  }
}

void WarmJointSolver::convertJoints(btTypedConstraint** joints, int joint_count,
                                    const btContactSolverInfo& info) {
  // Bullet sets its own functions when it is first used, just before this call.
  setConstraintRowSolverGeneric(SolveLimitedRow);
  setConstraintRowSolverLowerLimit(SolveContactRow);
  btSequentialImpulseConstraintSolver::convertJoints(joints, joint_count, info);
  ForEachJoint([&](const void* joint, int first, int end) {
    const auto last = last_.find(joint);
    if (last == last_.end() || static_cast<int>(last->second.size()) != end - first) return;
    for (int i = first; i < end; ++i) {
      btSolverConstraint& row = m_tmpSolverNonContactConstraintPool[i];
      AddImpulse(row, std::clamp(last->second[i - first], row.m_lowerLimit, row.m_upperLimit));
    }
  });
}

void WarmJointSolver::AddImpulse(btSolverConstraint& row, btScalar impulse) {
  btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA,
                         impulse);
  b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB,
                         impulse);
  row.m_appliedImpulse += impulse;
}

btScalar WarmJointSolver::solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                                        const btContactSolverInfo& info) {
  ForEachJoint([&](const void* joint, int first, int end) {
    std::vector<btScalar>& impulses = now_[joint];
    for (int i = first; i < end; ++i) {
      impulses.push_back(m_tmpSolverNonContactConstraintPool[i].m_appliedImpulse);
    }
  });
  return btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyFinish(bodies, body_count,
                                                                            info);
}

}  // namespace pickbed::sim
