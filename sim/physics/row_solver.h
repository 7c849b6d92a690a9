#pragma once

// Private to sim/physics: functions that solve one row of a joint, a friction or a contact.
//
// They compute exactly what Bullet's functions of double precision compute, but skip the parts that
// change nothing: fixed bodies, and contacts that stay without force. In a pile, many of Bullet's
// contact points carry no load.

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace pickbed::sim {

// Solves a row of a joint or a friction. Bullet calls it with the two bodies of the row. It changes
// the bodies' velocities and the row's impulse, and returns the change of relative velocity.
btScalar SolveLimitedRow(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row);
// The same for a contact, whose impulse has no upper limit.
btScalar SolveContactRow(btSolverBody& a, btSolverBody& b, const btSolverConstraint& row);

}  // namespace pickbed::sim
