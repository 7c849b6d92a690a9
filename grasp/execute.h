#pragma once

// Executes one grasp in a world rebuilt from the snapshot: approach, close, lift, hold, shake.

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/scene.h"
#include "sim/physics_world.h"

namespace pickbed {

struct ExecuteOptions {
  double approach_s = 0.6;
  double close_s = 0.6;  // waited at most for the fingers to come to rest on the part
  double lift_m = 0.20;  // above the bin's rim when that is more
  double lift_s = 1.0;
  double hold_s = 2.0;
  double shake_m = 0.005;
  double shake_hz = 5;
  double shake_s = 1.0;
  double settle_s = 1.5;       // at most, after a failed grasp, until the parts sleep again
  double stop_force_n = 40;    // on a finger during approach: collision
  double near_m = 0.02;        // bodies beyond the target's diameter plus this are static
  bool all_active = false;     // all bodies move and start awake: slow, to compare with
  double disturbed_m = 0.01;   // a neighbour that moved further is disturbed
  double stalled_mps = 0.002;  // fingers that close slower than this have met the part
  PhysicsOptions physics;
};

struct ExecuteResult {
  GraspOutcome outcome;
  Scene after;  // without what was carried off; neighbours where they came to rest
};

// `target_instance` is the instance that the hypothesis stood on (the nearest true one), -1 when
// there is none; success means that exactly that part is held at the end, or with -1 exactly one
// part, whichever it is. Neighbours that were thrown about are counted, not judged. Parts that left
// the bin are missing in `after`. Throws nothing but std::logic_error (objects without convex
// pieces, see sim/convex_pieces.h): a failed grasp is a result. Same inputs, same bytes.
ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const GripperSpec& gripper, int target_instance,
                           const ExecuteOptions& options = {});

}  // namespace pickbed
