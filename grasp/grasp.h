#pragma once

// A grasp: where the hand stands when its fingers close. Frame G: z approach, x closing, origin
// midway between the pads at the finger tips (sim/hand_joints.h).

#include <vector>

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
};

// In the world, for one hypothesis of a list.
struct Grasp {
  Pose X_WG = Pose::Identity();
  double width_m = 0;
  double score = 0;
  int hypothesis = 0;  // index into what was planned for
};

struct GraspOutcome {
  bool success = false;
  Loss loss = Loss::kPhysicsFailed;  // kNone on success
  int picked_instance = -1;          // Scene instance that came along, -1 = none
  int parts_lifted = 0;
  double final_opening_m = 0;
  double slip_m = 0;    // of the part in the hand, lift to end of shake
  double turn_rad = 0;  // likewise
  int disturbed = 0;    // neighbours that moved over 1 cm
};

}  // namespace pickbed
