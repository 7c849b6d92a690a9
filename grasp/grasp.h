#pragma once

// Grasp poses, and the outcome of an executed grasp. A grasp is the pose of the hand when its
// fingers close.
//
// Frame G: origin midway between the pads at the finger tips (sim/hands/jaw_hand.h).
//
//     +-----------+
//     |   palm    |
//     +-+-------+-+
//       |       |        fingers
//       |   G   |
//       |   o---|---> x  closing direction
//           |            y points to the reader
//           v z          approach direction

#include <string>
#include <vector>

#include "grasp/outcome.h"
#include "scenes/base/ids.h"
#include "scenes/geometry/pose.h"
#include "scenes/scenario/failure_reason.h"

namespace pickbed::grasp {

// Grasp on an object, in the frame O of that object.
struct GraspCandidate {
  Pose X_OG = Pose::Identity();
  double width_m = 0;  // distance between the two contacts
  double depth_m = 0;  // distance of the contact center behind the finger tips
  double quality = 0;  // 0..1, see grasp/candidates/{antipodal,suction}.h
  // Epsilon of Ferrari and Canny (grasp/candidates/wrench_space.h): the largest load that the grasp
  // resists in every direction. Forces are in weights of the object. Torques are about its center
  // of mass, in weights times half its diameter.
  double epsilon = 0;
  double robust = 0;  // 0..1, share of sampled errors under which the object is lifted
  // 0..1, probability that a pick at a pose with the expected error succeeds, by the tolerance
  // model of the object (grasp/tolerance/model_files.h); 0 = not computed. For the ranking
  // "tolerance".
  double tolerance = 0;
  // 0..1, how well the hand can set the object down (grasp/place/placement.h); 1 = the hand points
  // straight down and the object rests on its most probable side.
  double place_quality = 1;
};

// Grasp::hypothesis of a planner without poses.
inline constexpr int kNoHypothesis = -1;

// Planned grasp in the world frame, for one hypothesis or for none.
struct Grasp {
  Pose X_WG = Pose::Identity();
  double width_m = 0;
  double score = 0;
  int hypothesis = 0;  // index into PlanInput::poses; kNoHypothesis = planned without poses
  std::string tool;    // name of the gripper
  // Horizontal shift of the hand in W, in m, at the start of the lift, see
  // grasp/place/hand_motion.h; zero = straight up.
  Eigen::Vector2d lift_aside_m = Eigen::Vector2d::Zero();
};

// Outcome of an executed grasp: measured facts, and the verdict of each success rule.
struct GraspOutcome {
  bool success = false;                                   // by the rule in ExecuteOptions::rule
  FailureReason failure = FailureReason::kPhysicsFailed;  // kNone on success
  InstanceId picked_instance = kNoInstance;  // instance in the hand at the end, -1 = none
  int instances_lifted = 0;                  // instances in the hand after hold, shake and carry
  // Instances among them, other than the picked one, that were not in contact with the hand.
  int instances_entangled = 0;
  double final_opening_m = 0;
  double slip_m = 0;  // of the picked instance in the hand, from the lift to the end of the shake
  double in_hand_rotation_error_rad = 0;  // rotation in the hand, same interval
  int neighbors_displaced =
      0;  // neighbors that moved further than ExecuteOptions::displaced_m (1 cm)

  bool is_target = false;     // the picked instance is the target
  int instances_touched = 0;  // instances in contact with the closed hand
  int instances_risen = 0;    // instances in the hand at the end of the lift
  double lift_height_m = 0;   // of the instance that rose most, at the end of the lift
  // Mean load of the instances on the hand over the second half of the hold, in G about its origin.
  Eigen::Vector3d contact_force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d contact_torque_nm = Eigen::Vector3d::Zero();
  // State after the first 10 cm of the lift, for the rule vgn_loose. Not set if the lift did not
  // get so far.
  bool retreat_contact = false;
  double retreat_opening = 0;  // share of the stroke; a suction cup: 1 if it holds, else 0
  // Pose error of the picked instance on the table; valid only if `place_executed`.
  bool place_executed = false;          // it was set down on the table
  double place_error_m = 0;             // of the center of mass
  double place_rotation_error_rad = 0;  // minimum over the symmetries of the object

  // Results of the hold test (grasp/execute/retention.h); negative = not measured.
  double retention_g = -1;  // load at which the instance left the hand, multiples of g
  double drop_time_s = -1;  // from the end of the lift until the instance left the hand

  SuccessVerdicts verdicts{};
};

}  // namespace pickbed::grasp
