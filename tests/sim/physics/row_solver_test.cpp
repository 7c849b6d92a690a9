#include "sim/physics/row_solver.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include "scenes/base/random.h"
#include "sim/physics/warm_joints.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using btRowSolver = btSingleConstraintRowSolver;

btVector3 RandomVector(Rng& rng) { return {rng.Normal(), rng.Normal(), rng.Normal()}; }

// A body whose velocities the solver has changed, or a fixed one.
btSolverBody RandomBody(btRigidBody* body, Rng& rng) {
  btSolverBody solver_body;
  solver_body.m_originalBody = body;
  const bool is_fixed = body == nullptr;
  solver_body.m_deltaLinearVelocity = is_fixed ? btVector3(0, 0, 0) : RandomVector(rng);
  solver_body.m_deltaAngularVelocity = is_fixed ? btVector3(0, 0, 0) : RandomVector(rng);
  solver_body.m_linearFactor = RandomVector(rng);
  solver_body.m_angularFactor = RandomVector(rng);
  solver_body.m_invMass = is_fixed ? btVector3(0, 0, 0) : RandomVector(rng).absolute();
  return solver_body;
}

btSolverConstraint RandomRow(Rng& rng) {
  btSolverConstraint row;
  row.m_contactNormal1 = RandomVector(rng);
  row.m_contactNormal2 = -row.m_contactNormal1;
  row.m_relpos1CrossNormal = RandomVector(rng);
  row.m_relpos2CrossNormal = RandomVector(rng);
  row.m_angularComponentA = RandomVector(rng);
  row.m_angularComponentB = RandomVector(rng);
  row.m_jacDiagABInv = rng.Uniform(0.05, 2);
  row.m_rhs = rng.Normal();
  row.m_cfm = rng.Index(2) == 0 ? 0 : 0.1 * rng.Uniform();
  row.m_lowerLimit = -rng.Uniform() * rng.Index(2);
  row.m_upperLimit = rng.Uniform();
  row.m_appliedImpulse = rng.Index(2) == 0 ? 0 : 0.5 * rng.Uniform();
  return row;
}

// Solves random rows with both functions, and requires equal values.
void ExpectSameAsBullet(const btRowSolver& ours, const btRowSolver& bullets) {
  btRigidBody body(1, nullptr, nullptr);
  Rng rng(3);
  int unchanged = 0;
  for (int i = 0; i < 2000; ++i) {
    btSolverBody a = RandomBody(&body, rng);
    btSolverBody b = RandomBody(rng.Index(3) == 0 ? nullptr : &body, rng);
    btSolverConstraint row = RandomRow(rng);
    btSolverBody bullets_a = a, bullets_b = b;
    btSolverConstraint bullets_row = row;
    const btScalar change = ours(a, b, row);
    ASSERT_EQ(change, bullets(bullets_a, bullets_b, bullets_row)) << i;
    ASSERT_EQ(btScalar(row.m_appliedImpulse), btScalar(bullets_row.m_appliedImpulse)) << i;
    ASSERT_EQ(a.m_deltaLinearVelocity, bullets_a.m_deltaLinearVelocity) << i;
    ASSERT_EQ(a.m_deltaAngularVelocity, bullets_a.m_deltaAngularVelocity) << i;
    ASSERT_EQ(b.m_deltaLinearVelocity, bullets_b.m_deltaLinearVelocity) << i;
    ASSERT_EQ(b.m_deltaAngularVelocity, bullets_b.m_deltaAngularVelocity) << i;
    unchanged += change == 0;
  }
  EXPECT_GT(unchanged, 50);  // rows that stay at their limit
}

TEST(RowSolver, JointsAndFrictionAreSolvedAsByBullet) {
  btSequentialImpulseConstraintSolver solver;
  ExpectSameAsBullet(SolveLimitedRow, solver.getScalarConstraintRowSolverGeneric());
}

TEST(RowSolver, ContactsAreSolvedAsByBullet) {
  btSequentialImpulseConstraintSolver solver;
  ExpectSameAsBullet(SolveContactRow, solver.getScalarConstraintRowSolverLowerLimit());
}

// Bullet sets its own functions at the first step of a world.
TEST(RowSolver, WorldUsesTheseFunctions) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  WarmJointSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btSphereShape sphere(1);
  btRigidBody body(1, nullptr, &sphere, {1, 1, 1});
  world.addRigidBody(&body);
  world.stepSimulation(0.01, 0);
  EXPECT_EQ(solver.getActiveConstraintRowSolverGeneric(), &SolveLimitedRow);
  EXPECT_EQ(solver.getActiveConstraintRowSolverLowerLimit(), &SolveContactRow);
  world.removeRigidBody(&body);
}

}  // namespace
}  // namespace pickbed::tests
