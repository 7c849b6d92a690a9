#pragma once

// Chooses a grasp: candidates of every believed pose, moved into the world, checked against the bin
// and the observed cloud (never against the truth), ranked.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "grasp/antipodal.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/bin.h"

namespace pickbed {

// A believed pose; where it came from (truth, oracle, network, file) is no matter.
struct BelievedPose {
  int object = 0;
  Pose X_WO = Pose::Identity();
  double confidence = 1;
};

struct PlanInput {
  const Bin& bin;
  std::span<const BelievedPose> poses;
  std::span<const std::vector<GraspCandidate>> candidates;  // by object
  std::span<const Eigen::Vector3d> cloud_W;                 // observed points, bin included or not
  const ObjectSet& objects;
  const GripperSpec& gripper;
};

struct PlanOptions {
  int max_grasps = 5;           // reported
  double max_tilt_rad = 1.05;   // of the approach from straight down
  double own_points_m = 0.006;  // cloud points this near to the target's own surface are its own
};

struct PlanResult {
  std::vector<Grasp> grasps;            // best first
  std::map<std::string, int> rejected;  // cause -> count
};

PlanResult PlanGrasps(const PlanInput& input, const PlanOptions& options = {});

}  // namespace pickbed
