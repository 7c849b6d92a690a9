#pragma once

// Executes one grasp in a world rebuilt from the snapshot. A free-flying hand approaches, closes,
// lifts, holds, shakes, carries the object out of the bin and sets it down.

#include <optional>

#include "grasp/execute/attempt_world.h"
#include "grasp/execute/motion_listener.h"
#include "grasp/execute/retention.h"
#include "grasp/execute/settle.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/place/placement.h"
#include "scenes/base/ids.h"
#include "scenes/scene.h"
#include "sim/physics/physics_world.h"

namespace pickbed::grasp {

// Motion, stop conditions and success rule of an execution.
struct ExecuteOptions {
  // Peak speed of approach and retreat. From 0.2 m/s on, an impact within one step of 240 Hz moves
  // instances further than a finger may yield. Then one verdict in 15 of difficult grasps differed
  // from the verdict at 960 Hz.
  double approach_mps = 0.15;
  double stop_yield_m = 0.001;  // a finger pushed back further on the approach: collision
  double stop_force_n = 40;  // mean force of instances on palm or stem on the approach: collision
  double stop_window_s = 0.0125;   // of that mean; the peak of an impact depends on the time step
  double stop_depth_m = 0.001;     // palm deeper in the bin or a static instance: collision
  double close_s = 0.6;            // maximum wait until the fingers come to rest on the instance
  double stalled_mps = 0.002;      // fingers slower than this have met the instance
  double stalled_window_s = 0.05;  // of that speed; longer than the acceleration of the fingers
  double lift_m = 0.20;            // higher if the rim of the bin requires it
  double lift_s = 1.0;             // longer if the peak speed would exceed lift_mps
  double lift_mps = 0.5;
  double retreat_m = 0.10;  // height of the lift at which the rule vgn_loose is evaluated
  double hold_s = 2.0;
  double shake_m = 0.005;
  double shake_hz = 5;
  double shake_s = 1.0;
  bool carry = true;           // out of the bin to the table; else the attempt ends after the shake
  double carry_mps = 0.8;      // peak speed of the hand during the carry
  double settle_s = 1.5;       // maximum time after the retreat until the instances sleep again
  double displaced_m = 0.01;   // a neighbor that moved further counts as displaced
  RetentionOptions retention;  // after a successful pick
  AttemptWorldOptions world;
  SettleOptions settle;  // after the attempt
  PlaceOptions place;
  RuleOptions rules;
  SuccessRule rule = SuccessRule::kRightInstance;  // decides GraspOutcome::success
  // Neighbors at rest keep their contacts, as they did while the bin was filled. Contacts of the
  // hand are searched in every step.
  PhysicsOptions physics{.sleep_after_s = 0.25,
                         .contact_reuse_m = 0.0001,
                         .awake_boxes_only = true,
                         .wake_by_contact = true};
  // Visits all options except `rule`, `retention` and `physics`, whose values were measured.
  void Visit(SettingsVisitor& v);
};

// Target of the grasp, and what the cell assumes about it. The placement is planned from the
// assumed values and evaluated against them. Without them, the true ones are used. An unknown
// target is placed in the orientation in which it was picked.
struct GraspTarget {
  InstanceId instance = kNoInstance;   // true instance nearest to the hypothesis, -1 = none
  ObjectId object = kAnyObject;        // without an instance: required object, -1 = any
  std::optional<Pose> X_WO;            // estimated pose
  const ObjectModel* model = nullptr;  // of nominal size; null = as in the scene
  std::optional<Pose> planned_X_WG;    // without the error of the robot

  // Implicit, so that an instance can be passed directly.
  GraspTarget(InstanceId target_instance = kNoInstance, ObjectId target_object = kAnyObject,
              const std::optional<Pose>& estimated_X_WO = std::nullopt,
              const ObjectModel* assumed_model = nullptr)
      : instance(target_instance),
        object(target_object),
        X_WO(estimated_X_WO),
        model(assumed_model) {}

  bool IsUnknown() const { return instance == kNoInstance && object == kAnyObject && !X_WO; }
};

// Outcome of a grasp and the scene after it.
struct ExecuteResult {
  GraspOutcome outcome;
  Scene after;  // without the removed instances; neighbors where they came to rest
};

// Executes the grasp on the snapshot `scene`. A failed grasp is a result. Displaced neighbors are
// counted but do not affect success. Instances that left the bin are missing in `after`. Equal
// inputs give identical bytes. Calls `on_step`, if not empty, after each step. Throws InputError
// for a grasp that is not finite, and std::logic_error for objects without convex pieces (see
// sim/convex/convex_pieces.h).
ExecuteResult ExecuteGrasp(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                           const Gripper& gripper, const GraspTarget& target,
                           const ExecuteOptions& options = {}, const MotionListener& on_step = {});

}  // namespace pickbed::grasp
