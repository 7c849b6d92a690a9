#pragma once

// Brings instances to rest that an attempt left without support.
//
// During an attempt only the instances near the target and the hand can move (attempt_world.h). An
// instance further away may rest on one that moved. It would hover until a later attempt wakes it,
// and then fall against the hand.

#include "grasp/layer.h"
#include "scenes/base/settings.h"
#include "scenes/objects/object_model.h"
#include "scenes/scene.h"
#include "sim/physics/physics_world.h"

namespace pickbed::grasp {

// Limits of SettleDisturbed.
struct SettleOptions {
  double moved_m = 0.001;  // an instance whose surface moved further disturbs its neighbors
  double gap_m = 0.002;    // distance of two bounding boxes up to which instances are neighbors
  double max_s = 1.5;      // maximum simulated time of one round
  int max_rounds = 8;      // 0 = nothing is settled
  void Visit(SettingsVisitor& v);
};

// Returns `after` with its instances at rest. An instance may move if it is a neighbor of one that
// moved since `before`. Each round moves the neighbors of the instances that moved in the round
// before, until none moves. Instances that leave the bin are removed. Throws std::logic_error for
// objects without convex pieces.
Scene SettleDisturbed(const Scene& before, Scene after, const ObjectSet& objects,
                      const SettleOptions& options, const PhysicsOptions& physics);

}  // namespace pickbed::grasp
