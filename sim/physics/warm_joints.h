#pragma once

// Private to sim/physics: joints that start from their last impulses.
//
// Bullet starts each joint of a step without impulse, but contacts with most of their last one. A
// finger that presses on an object is then out of balance at the start of each step: the contact
// pushes it back, and its drive does not push yet. The solver needs up to 200 iterations to find
// the balance again. With the last impulses, a hand at rest is solved from the start.

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <map>
#include <vector>

namespace pickbed::sim {

// Bullet's solver, whose joints keep their impulses from step to step while their number of rows
// stays the same.
class WarmJointSolver : public btSequentialImpulseConstraintSolver {
 public:
  // Must be called before each step of the world, which may solve its islands one by one.
  void BeginStep();

 protected:
  void convertJoints(btTypedConstraint** joints, int joint_count,
                     const btContactSolverInfo& info) override;
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override;
  // Adds an impulse to a row of a joint or contact, and to its two bodies.
  void AddImpulse(btSolverConstraint& row, btScalar impulse);

 private:
  // Visits the rows of each joint in the solver's list: visit(joint, first row, end).
  template <typename Visit>
  void ForEachJoint(const Visit& visit);

  // Impulses of each joint's rows, by the joint, in the last step and in this one.
  std::map<const void*, std::vector<btScalar>> last_, now_;
};

}  // namespace pickbed::sim
