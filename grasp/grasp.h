#pragma once

// A grasp: where the hand stands when its fingers close. Frame G: z approach, x closing, origin
// midway between the pads at the finger tips (sim/hand_joints.h).

#include <vector>

#include "grasp/success_rules.h"
#include "scenes/loss.h"
#include "scenes/pose.h"

namespace pickbed {

// In the frame of the part it was computed on.
struct GraspCandidate {
  Pose X_OG = Pose::Identity();
  double width_m = 0;  // distance of the two contacts
  double depth_m = 0;  // of the contact's middle behind the finger tips
  double quality = 0;  // 0..1
  // Ferrari and Canny's epsilon (grasp/wrench_space.h): the largest load from any direction that is
  // held, forces in weights of the part, torques about its centre of mass in weights times half its
  // diameter.
  double epsilon = 0;
  double robust = 0;  // 0..1, share of sampled errors under which the part is lifted
  // 0..1, how well the hand can lay the part down (grasp/place.h); 1 = straight down on its
  // likeliest side.
  double set_down = 1;
};

// In the world, for one hypothesis of a list.
struct Grasp {
  Pose X_WG = Pose::Identity();
  double width_m = 0;
  double score = 0;
  int hypothesis = 0;  // index into what was planned for
};

// What became of an executed grasp: facts, and what each rule of success makes of them.
struct GraspOutcome {
  bool success = false;              // by the rule that decides, see ExecuteOptions::rule
  Loss loss = Loss::kPhysicsFailed;  // kNone on success
  int picked_instance = -1;          // Scene instance that came along, -1 = none
  int parts_lifted = 0;              // in the hand to the end: after hold, shake and carry
  double final_opening_m = 0;
  double slip_m = 0;    // of the part in the hand, lift to end of shake
  double turn_rad = 0;  // likewise
  int disturbed = 0;    // neighbours that moved over 1 cm

  bool is_target = false;    // the picked part is the one that was meant
  int parts_touched = 0;     // by the hand once it had closed
  int parts_risen = 0;       // that hung in the hand at the end of the lift
  double lift_height_m = 0;  // of the part that rose most, at the end of the lift
  // Of the parts on the hand, in G about its origin, mean of the hold's second half.
  Eigen::Vector3d contact_force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d contact_torque_nm = Eigen::Vector3d::Zero();
  // After the first 10 cm of the lift, for the loose rule; of a hand that came so far.
  bool retreat_contact = false;
  double retreat_opening = 0;  // share of the stroke; a hand without one: 1 while it holds, else 0
  // Where the part lies against where it was to lie; only where it was set down.
  bool set_down = false;
  double place_error_m = 0;   // of the centre of mass
  double place_turn_rad = 0;  // least over the part's symmetries

  SuccessVerdicts verdicts{};
};

}  // namespace pickbed
