#include "sim/physics/patch_friction.h"

#include <algorithm>
#include <cmath>

#include "sim/physics/bullet_types.h"
#include "sim/physics/pad_geometry.h"

namespace pickbed::sim {
namespace {

// Visits the object's convex pieces, each with its pose in the pad frame.
template <typename Visit>
void ForEachPiece(const btCollisionShape& shape, const btTransform& X_PB, const Visit& visit) {
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
      ForEachPiece(*compound.getChildShape(i), X_PB * compound.getChildTransform(i), visit);
    }
  } else if (shape.getShapeType() == CONVEX_HULL_SHAPE_PROXYTYPE) {
    visit(static_cast<const btConvexHullShape&>(shape), X_PB);
  }
}

// Returns the outline (y, z) of the object's pieces on the pad face at `side` of x, in Bullet's
// units. Surfaces on the finger's other side, such as the far wall of a hollow object, do not
// count.
std::vector<Eigen::Vector2d> OutlineOnPad(const btBoxShape& pad, const btCollisionShape& instance,
                                          const btTransform& X_PB, btScalar side, btScalar gives) {
  const btVector3 half = pad.getHalfExtentsWithMargin();
  std::vector<Eigen::Vector2d> touching;
  ForEachPiece(instance, X_PB, [&](const btConvexHullShape& hull, const btTransform& X_PH) {
    const btScalar reach = hull.getMargin() + gives;
    std::vector<Eigen::Vector2d> corners;
    for (int i = 0; i < hull.getNumPoints(); ++i) {
      const btVector3 p = X_PH * hull.getScaledPoint(i);
      if (side * p.x() > 0 && side * p.x() - half.x() < reach) corners.emplace_back(p.y(), p.z());
    }
    for (const Eigen::Vector2d& p :
         ClippedToRectangle(ConvexOutline(std::move(corners)), {half.y(), half.z()})) {
      touching.push_back(p);
    }
  });
  return ConvexOutline(std::move(touching));
}

}  // namespace

void PadOptions::Visit(SettingsVisitor& v) {
  v.Real("gives_m", gives_m, {0, 0.001}, "distance at which a surface touches the pad, m");
  v.Real("outline_update_s", outline_update_s, {0, 10},
         "interval after which a sticking patch's outline is updated, s");
}

void PatchFrictionSolver::BeginStep() {
  WarmJointSolver::BeginStep();
  ++step_;
  frictions_.clear();
}

void PatchFrictionSolver::convertContacts(btPersistentManifold** manifolds, int manifold_count,
                                          const btContactSolverInfo& info) {
  WarmJointSolver::convertContacts(manifolds, manifold_count, info);
  patches_.clear();
  if (pads.empty()) return;
  FindPatches(info);
  for (Patch& patch : patches_) Prepare(patch, info);
}

// Collects the pads' contacts into patches and disables Bullet's own friction for them.
void PatchFrictionSolver::FindPatches(const btContactSolverInfo& info) {
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    const btRigidBody* a = m_tmpSolverBodyPool[row.m_solverBodyIdA].m_originalBody;
    const btRigidBody* b = m_tmpSolverBodyPool[row.m_solverBodyIdB].m_originalBody;
    const bool a_is_pad = std::find(pads.begin(), pads.end(), a) != pads.end();
    const btRigidBody* pad = a_is_pad ? a : b;
    const btRigidBody* instance = a_is_pad ? b : a;
    if (!a_is_pad && std::find(pads.begin(), pads.end(), b) == pads.end()) continue;
    if (instance == nullptr) continue;
    const btSolverConstraint& contact = m_tmpSolverContactConstraintPool[row.m_frictionIndex];
    const auto& point = *static_cast<btManifoldPoint*>(contact.m_originalContactPoint);
    const btVector3 axis = pad->getWorldTransform().getBasis().getColumn(0);
    if (std::abs(axis.dot(point.m_normalWorldOnB)) < kPadNormal) continue;
    row.m_friction = 0;
    Memory* memory = &memories_[{pad, instance}];
    auto patch = std::find_if(patches_.begin(), patches_.end(),
                              [&](const Patch& known) { return known.memory == memory; });
    if (patch == patches_.end()) {
      patches_.push_back({});
      patch = std::prev(patches_.end());
      patch->memory = memory;
      patch->pad_id = a_is_pad ? row.m_solverBodyIdA : row.m_solverBodyIdB;
      patch->instance_id = a_is_pad ? row.m_solverBodyIdB : row.m_solverBodyIdA;
    }
    if (!patch->contacts.empty() && patch->contacts.back() == row.m_frictionIndex) continue;
    patch->contacts.push_back(row.m_frictionIndex);
    patch->friction = point.m_combinedFriction;
    // Bullet starts a contact from a share of its last impulse. The solver must find the rest
    // again, which takes more iterations than available with heavy fingers on a light object: the
    // pads sank 4 mm into a 15 mm cube of 10 g and threw it. So the missing share is added here.
    AddImpulse(m_tmpSolverContactConstraintPool[row.m_frictionIndex],
               (1 - info.m_warmstartingFactor) * point.getAppliedImpulse());
    patch->points.push_back(point.getPositionWorldOnA());
  }
}

// At a corner or a bulge there is no outline. The contact points replace it then.
void PatchFrictionSolver::UpdateOutline(Patch& patch) const {
  const btRigidBody& pad = *m_tmpSolverBodyPool[patch.pad_id].m_originalBody;
  const btRigidBody& instance = *m_tmpSolverBodyPool[patch.instance_id].m_originalBody;
  const btTransform X_PW = pad.getWorldTransform().inverse();
  std::vector<Eigen::Vector2d> contacts;
  btScalar x = 0;
  for (const btVector3& point : patch.points) {
    const btVector3 point_P = X_PW * point;
    contacts.emplace_back(point_P.y(), point_P.z());
    x += point_P.x() / static_cast<btScalar>(patch.points.size());
  }
  std::vector<Eigen::Vector2d> outline = OutlineOnPad(
      static_cast<const btBoxShape&>(*pad.getCollisionShape()), *instance.getCollisionShape(),
      X_PW * instance.getWorldTransform(), x < 0 ? -1 : 1, options_.gives_m * kUnitsPerMeter);
  if (outline.empty()) outline = ConvexOutline(std::move(contacts));
  const EvenPressure pressure = PressureOn(outline);
  patch.memory->center_P = btVector3(x, pressure.center.x(), pressure.center.y());
  patch.memory->arm = pressure.arm;
}

void PatchFrictionSolver::Prepare(Patch& patch, const btContactSolverInfo& info) {
  Memory& memory = *patch.memory;
  const btRigidBody& pad = *m_tmpSolverBodyPool[patch.pad_id].m_originalBody;
  const btRigidBody& instance = *m_tmpSolverBodyPool[patch.instance_id].m_originalBody;
  const btTransform& X_WP = pad.getWorldTransform();
  const btTransform X_PB = X_WP.inverse() * instance.getWorldTransform();
  if (memory.step != step_ - 1) memory = Memory();  // there was no contact one step ago
  memory.step = step_;

  const long renewed_after = std::max(1L, std::lround(options_.outline_update_s / info.m_timeStep));
  if (memory.has_slipped || memory.age % renewed_after == 0) UpdateOutline(patch);
  if (memory.has_slipped) memory.X_PB = X_PB;
  memory.has_slipped = false;
  ++memory.age;

  const btVector3 center = X_WP * memory.center_P;
  // Maps the patch from where it stuck on the object to where it is now.
  const btTransform stuck = X_WP * memory.X_PB * instance.getWorldTransform().inverse();
  const btVector3 drift = stuck * center - center;  // of the pad relative to the object
  const btQuaternion turn = stuck.getRotation();
  const btVector3 turned = 2 * (turn.w() < 0 ? -1 : 1) * btVector3(turn.x(), turn.y(), turn.z());
  const btMatrix3x3& axes = X_WP.getBasis();
  const btScalar pull_back = info.m_frictionERP / info.m_timeStep;
  for (int i = 0; i < kRows; ++i) {
    Row& row = patch.rows[i];
    const bool is_turn = i == 2;
    const btVector3 axis = axes.getColumn(is_turn ? 0 : 1 + i);
    row.linear = is_turn ? btVector3(0, 0, 0) : axis;
    row.turn_pad = is_turn ? axis : (center - pad.getCenterOfMassPosition()).cross(axis);
    row.turn_instance =
        is_turn ? -axis : -(center - instance.getCenterOfMassPosition()).cross(axis);
    row.answer_pad = pad.getInvInertiaTensorWorld() * row.turn_pad;
    row.answer_instance = instance.getInvInertiaTensorWorld() * row.turn_instance;
    row.wanted = -pull_back * (is_turn ? turned : drift).dot(axis);
    row.inverse_mass =
        row.turn_pad.dot(row.answer_pad) + row.turn_instance.dot(row.answer_instance);
    if (!is_turn) row.inverse_mass += pad.getInvMass() + instance.getInvMass();
  }
  patch.impulse = memory.impulse;
  Apply(patch, patch.impulse);
}

void PatchFrictionSolver::Apply(const Patch& patch, const btVector3& impulse) {
  btSolverBody& pad = m_tmpSolverBodyPool[patch.pad_id];
  btSolverBody& instance = m_tmpSolverBodyPool[patch.instance_id];
  for (int i = 0; i < kRows; ++i) {
    const Row& row = patch.rows[i];
    pad.internalApplyImpulse(row.linear * pad.internalGetInvMass(), row.answer_pad, impulse[i]);
    instance.internalApplyImpulse(-row.linear * instance.internalGetInvMass(), row.answer_instance,
                                  impulse[i]);
  }
}

btScalar PatchFrictionSolver::RelativeVelocity(const Patch& patch, const Row& row) const {
  const auto linear = [](const btSolverBody& body) {
    return body.m_linearVelocity + body.m_externalForceImpulse + body.m_deltaLinearVelocity;
  };
  const auto angular = [](const btSolverBody& body) {
    return body.m_angularVelocity + body.m_externalTorqueImpulse + body.m_deltaAngularVelocity;
  };
  const btSolverBody& pad = m_tmpSolverBodyPool[patch.pad_id];
  const btSolverBody& instance = m_tmpSolverBodyPool[patch.instance_id];
  return row.linear.dot(linear(pad) - linear(instance)) + row.turn_pad.dot(angular(pad)) +
         row.turn_instance.dot(angular(instance));
}

btScalar PatchFrictionSolver::Solve(Patch& patch) {
  const btVector3 before = patch.impulse;
  btScalar normal = 0;
  for (const int contact : patch.contacts) {
    normal += m_tmpSolverContactConstraintPool[contact].m_appliedImpulse;
  }
  for (int i = 0; i < kRows; ++i) {
    const Row& row = patch.rows[i];
    btVector3 step(0, 0, 0);
    step[i] = (row.wanted - RelativeVelocity(patch, row)) / row.inverse_mass;
    patch.impulse[i] += step[i];
    Apply(patch, step);
  }
  const btScalar maximum = patch.friction * std::max(btScalar(0), normal);
  const btScalar max_turn = maximum * patch.memory->arm;
  const btScalar slide = maximum > 0 ? std::hypot(patch.impulse[0], patch.impulse[1]) / maximum : 0;
  const btScalar twist = max_turn > 0 ? patch.impulse[2] / max_turn : 0;
  const btScalar share = std::hypot(slide, twist);
  btVector3 allowed = patch.impulse;
  if (!(maximum > 0)) allowed.setZero();
  if (!(max_turn > 0)) allowed[2] = 0;
  if (share > 1) allowed /= share;
  patch.is_slipping = share > 1 || !(maximum > 0);
  Apply(patch, allowed - patch.impulse);
  patch.impulse = allowed;
  btScalar max_change = 0;
  for (int i = 0; i < kRows; ++i) {
    const btScalar change = (allowed[i] - before[i]) * patch.rows[i].inverse_mass;
    max_change = std::max(max_change, change * change);
  }
  return max_change;
}

btScalar PatchFrictionSolver::solveSingleIteration(
    int iteration, btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
    int manifold_count, btTypedConstraint** constraints, int constraint_count,
    const btContactSolverInfo& info, btIDebugDraw* draw) {
  btScalar residual = WarmJointSolver::solveSingleIteration(iteration, bodies, body_count,
                                                            manifolds, manifold_count, constraints,
                                                            constraint_count, info, draw);
  for (Patch& patch : patches_) residual = std::max(residual, Solve(patch));
  return iteration + 1 < min_iterations ? SIMD_INFINITY : residual;
}

PadFriction PatchFrictionSolver::FrictionOf(const Patch& patch, btScalar step_s) const {
  const btRigidBody& pad = *m_tmpSolverBodyPool[patch.pad_id].m_originalBody;
  btVector3 force(0, 0, 0), torque(0, 0, 0);
  for (int i = 0; i < kRows; ++i) {
    const Row& row = patch.rows[i];
    force += patch.impulse[i] / step_s * row.linear;
    if (i == 2) torque += patch.impulse[i] / step_s * row.turn_pad;
  }
  return {FromBullet(force), FromBullet(torque) / kUnitsPerMeter,
          FromBullet(pad.getWorldTransform() * patch.memory->center_P)};
}

btScalar PatchFrictionSolver::solveGroupCacheFriendlyFinish(btCollisionObject** bodies,
                                                            int body_count,
                                                            const btContactSolverInfo& info) {
  for (const Patch& patch : patches_) {
    patch.memory->impulse = patch.impulse;
    patch.memory->has_slipped = patch.is_slipping;
    frictions_.push_back(FrictionOf(patch, info.m_timeStep));
  }
  patches_.clear();
  return WarmJointSolver::solveGroupCacheFriendlyFinish(bodies, body_count, info);
}

}  // namespace pickbed::sim
