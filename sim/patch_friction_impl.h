#pragma once

// Private to sim's physics: friction of a pad that lies flat on a part.
//
// Bullet knows a patch of contact by up to four points and lets friction act on each for itself:
// the torque that a pad holds then hangs on where those points happen to lie, 1.2 to 1.9 times that
// of even pressure over the patch. For the bodies named here a patch has one friction of its own: a
// force f at the patch's centre and a torque t about the normal, together within
//   (f / (mu N))^2 + (t / (mu N r))^2 <= 1
// where N is the normal force of the whole patch and r the mean distance of the patch's points from
// its centre, which is the torque of even pressure (Howe and Cutkosky 1996, "Practical force-motion
// models for sliding manipulation"). While it sticks, a memory of where it stuck keeps it from
// creeping, as Bullet's friction anchors do. Normal forces are Bullet's.

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <btBulletDynamicsCommon.h>

#include <map>
#include <utility>
#include <vector>

#include "sim/bullet_bridge.h"
#include "sim/physics_world.h"

namespace pickbed {

class PatchFrictionSolver : public btSequentialImpulseConstraintSolver {
 public:
  explicit PatchFrictionSolver(const PadOptions& options) : options_(options) {}

  // Boxes whose faces across their x are pads. To be emptied before they are destroyed.
  std::vector<const btRigidBody*> pads;
  // Before these are done no step counts as solved: what is left after them may be small against
  // the world's residual and yet large against the weight of a light part.
  int least_iterations = 0;

  // To be called before each step of the world, which may solve its islands one by one.
  void BeginStep();
  // Of the last step.
  const std::vector<PadFriction>& frictions() const { return frictions_; }

 protected:
  void convertContacts(btPersistentManifold** manifolds, int manifold_count,
                       const btContactSolverInfo& info) override;
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count,
                                btTypedConstraint** constraints, int constraint_count,
                                const btContactSolverInfo& info, btIDebugDraw* draw) override;
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override;

 private:
  // Two directions across the normal, then the turn about it.
  static constexpr int kRows = 3;

  // What is kept of a pad and a part from step to step.
  struct Memory {
    btTransform X_PB = btTransform::getIdentity();  // of the part in the pad's frame where it stuck
    btVector3 impulse{0, 0, 0};
    btVector3 center_P{0, 0, 0};
    btScalar arm = 0;  // r
    bool has_slipped = true;
    long age = 0;
    long step = -1;
  };

  struct Row {
    btVector3 linear;    // along which the pad's motion counts, the part's against it
    btVector3 turn_pad;  // J of the angular velocities
    btVector3 turn_part;
    btVector3 answer_pad;  // inverse inertia times that
    btVector3 answer_part;
    btScalar wanted = 0;  // relative velocity that undoes the drift
    btScalar inverse_mass = 0;
  };

  struct Patch {
    Memory* memory;
    int pad_id;  // solver bodies
    int part_id;
    std::vector<int> contacts;  // rows of normal forces
    btScalar friction = 0;
    std::vector<btVector3> points;  // of the contacts, in W
    Row rows[kRows];
    btVector3 impulse{0, 0, 0};
    bool is_slipping = false;
  };

  void TopUp(int contact, btScalar share);
  void FindPatches(const btContactSolverInfo& info);
  void LookAtOutline(Patch& patch) const;
  void Prepare(Patch& patch, const btContactSolverInfo& info);
  void Apply(const Patch& patch, const btVector3& impulse);
  btScalar RelativeVelocity(const Patch& patch, const Row& row) const;
  btScalar Solve(Patch& patch);  // square of the largest change of relative velocity

  PadFriction FrictionOf(const Patch& patch, btScalar step_s) const;

  const PadOptions options_;
  std::vector<Patch> patches_;
  std::vector<PadFriction> frictions_;
  std::map<std::pair<const btRigidBody*, const btRigidBody*>, Memory> memories_;
  long step_ = 0;
};

}  // namespace pickbed
