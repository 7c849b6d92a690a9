#pragma once

// Private to sim/physics: friction of a flat pad on an object.
//
// Bullet represents a contact patch by up to four points with independent friction. The friction
// torque then depends on the positions of these points: it is 1.2 to 1.9 times the torque of
// uniform pressure over the patch. For the bodies in `pads`, each patch has a single friction
// instead: a force f at the patch's center and a torque t about the normal, limited by
//   (f / (mu N))^2 + (t / (mu N r))^2 <= 1
// N is the normal force of the whole patch. r is the mean distance of the patch's points to its
// center, which gives the torque of uniform pressure (Howe and Cutkosky 1996, "Practical
// force-motion models for sliding manipulation"). While the patch sticks, its stored sticking pose
// prevents creep, as Bullet's friction anchors do. Normal forces are Bullet's.

#include <btBulletDynamicsCommon.h>

#include <map>
#include <utility>
#include <vector>

#include "sim/physics/attached_hand.h"
#include "sim/physics/bullet_types.h"
#include "sim/physics/physics_world.h"
#include "sim/physics/warm_joints.h"

namespace pickbed::sim {

// Solver with one friction per pad patch. Contacts on a pad face start from their last impulses,
// like joints.
class PatchFrictionSolver : public WarmJointSolver {
 public:
  explicit PatchFrictionSolver(const PadOptions& options) : options_(options) {}

  // Boxes whose faces perpendicular to x are pads. Clear it before the bodies are destroyed.
  std::vector<const btRigidBody*> pads;
  // Minimum number of iterations per step. The residual after fewer iterations may be small for the
  // world but large compared to the weight of a light object.
  int min_iterations = 0;

  // Must be called before each step of the world, which may solve its islands one by one.
  void BeginStep();
  // Friction of each patch in the last step.
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
  // Two directions perpendicular to the normal, then the rotation about it.
  static constexpr int kRows = 3;

  // State of a pad-object pair that is kept between steps.
  struct Memory {
    btTransform X_PB = btTransform::getIdentity();  // object in the pad frame, where it stuck
    btVector3 impulse{0, 0, 0};
    btVector3 center_P{0, 0, 0};
    btScalar arm = 0;  // r
    bool has_slipped = true;
    long age = 0;
    long step = -1;
  };

  struct Row {
    btVector3 linear;    // direction of the force on the pad; the object gets the opposite
    btVector3 turn_pad;  // Jacobian of the angular velocities
    btVector3 turn_instance;
    btVector3 answer_pad;  // inverse inertia times the Jacobian
    btVector3 answer_instance;
    btScalar wanted = 0;  // relative velocity that removes the drift
    btScalar inverse_mass = 0;
  };

  struct Patch {
    Memory* memory;
    int pad_id;  // solver body ids
    int instance_id;
    std::vector<int> contacts;  // rows of the normal forces
    btScalar friction = 0;
    std::vector<btVector3> points;  // contact points in W
    Row rows[kRows];
    btVector3 impulse{0, 0, 0};
    bool is_slipping = false;
  };

  void FindPatches(const btContactSolverInfo& info);
  void UpdateOutline(Patch& patch) const;
  void Prepare(Patch& patch, const btContactSolverInfo& info);
  void Apply(const Patch& patch, const btVector3& impulse);
  btScalar RelativeVelocity(const Patch& patch, const Row& row) const;
  btScalar Solve(Patch& patch);  // returns the squared largest change of relative velocity

  PadFriction FrictionOf(const Patch& patch, btScalar step_s) const;

  const PadOptions options_;
  std::vector<Patch> patches_;
  std::vector<PadFriction> frictions_;
  std::map<std::pair<const btRigidBody*, const btRigidBody*>, Memory> memories_;
  long step_ = 0;
};

}  // namespace pickbed::sim
