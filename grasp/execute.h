#pragma once

// Executes one grasp in a world rebuilt from the snapshot: a free-flying hand approaches, closes,
// lifts, holds, shakes, carries the part out of the bin and sets it down.

#include <optional>

#include "grasp/attempt_world.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/place.h"
#include "scenes/scene.h"
#include "sim/physics_world.h"

namespace pickbed {

struct ExecuteOptions {
  // Largest speed of approach and of drawing back. From .2 m/s on a blow moves parts by more than
  // a finger may yield within one step of 240 Hz: one verdict in 15 of hard grasps was another
  // than at 960 Hz.
  double approach_mps = 0.15;
  double stop_yield_m = 0.001;     // a finger pushed back by more on the approach: collision
  double stop_force_n = 40;        // mean of parts on palm or stem during approach: collision
  double stop_window_s = 0.0125;   // of that mean: a blow's peak depends on the step's length
  double stop_depth_m = 0.001;     // of the palm in the bin or in a static part: likewise
  double close_s = 0.6;            // waited at most for the fingers to come to rest on the part
  double stalled_mps = 0.002;      // fingers that close slower than this have met the part
  double stalled_window_s = 0.05;  // of that speed: longer than the start of their acceleration
  double lift_m = 0.20;            // above the bin's rim when that is more
  double lift_s = 1.0;             // longer where the speed would be more than the next
  double lift_mps = 0.5;
  double retreat_m = 0.10;  // of the lift, after which the loose rule of success is judged
  double hold_s = 2.0;
  double shake_m = 0.005;
  double shake_hz = 5;
  double shake_s = 1.0;
  bool carry = true;          // out of the bin to the table; else it ends with the shake
  double carry_mps = 0.8;     // largest speed of the hand on the way
  double settle_s = 1.5;      // at most, once the hand has opened, until the parts sleep again
  double disturbed_m = 0.01;  // a neighbour that moved further is disturbed
  AttemptWorldOptions world;
  PlaceOptions place;
  RuleOptions rules;
  SuccessRule rule = SuccessRule::kRightPart;  // decides what `success` says
  // Neighbours at rest keep their contacts, as they did while the bin was filled; the hand's own
  // are looked for in every step.
  PhysicsOptions physics{
      .sleep_after_s = 0.25, .contact_reuse_m = 0.0001, .awake_boxes_only = true};
  // All but the rule and the physics, whose figures were measured.
  void Visit(SettingsVisitor& v);
};

// What the grasp was meant for.
struct GraspTarget {
  int instance = -1;  // that the hypothesis stands on (the nearest true one), -1 = none
  int object = -1;    // without an instance: the kind that will do, -1 = any
  // Where it was believed: what is set down is judged against that. Nothing = where it truly lay.
  std::optional<Pose> X_WO;

  // Also from a bare instance.
  GraspTarget(int target_instance = -1, int target_object = -1,
              const std::optional<Pose>& believed_X_WO = std::nullopt)
      : instance(target_instance), object(target_object), X_WO(believed_X_WO) {}
};

struct ExecuteResult {
  GraspOutcome outcome;
  Scene after;  // without what was carried off; neighbours where they came to rest
};

// Throws nothing but std::logic_error (objects without convex pieces, see sim/convex_pieces.h): a
// failed grasp is a result. Neighbours that were thrown about are counted, not judged. Parts that
// left the bin are missing in `after`. Same inputs, same bytes.
ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const GripperSpec& gripper, const GraspTarget& target,
                           const ExecuteOptions& options = {});

}  // namespace pickbed
