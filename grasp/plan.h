#pragma once

// Chooses a grasp: candidates of every believed pose, moved into the world, checked against the bin
// and the observed cloud (never against the truth), ranked.
//
// Other believed poses stand in for what the camera cannot see of the target's neighbours: their
// surfaces are obstacles like observed points.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "scenes/bin.h"
#include "scenes/object_model.h"
#include "scenes/settings.h"

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
  std::span<const int> aims = {};  // indices of poses that may be grasped; none = all may
};

// By what of a candidate grasps are ranked, beside the confidence of the pose, height and room.
struct RankingRow {
  const char* name;
  const char* help;
  double (*value)(const GraspCandidate& candidate);  // null = by chance alone
};
std::span<const RankingRow> RankingTable();
// Throws InputError with the known names.
const RankingRow& RankingNamed(const std::string& name);

// For a second look where the first one found nothing.
struct WiderLimits {
  bool look = true;
  double max_tilt_rad = 1.3;
  double min_quality = 0.15;
  double clearance_share = 0.3;    // of the gripper's clearance
  double bin_clearance_m = 0.001;  //
  void Visit(SettingsVisitor& v);
};

struct PlanOptions {
  int max_grasps = 5;               // reported
  std::string ranking = "quality";  // a row of RankingTable()
  uint64_t seed = 0;                // of the ranking by chance
  double max_tilt_rad = 1.05;       // of the approach from straight down
  double own_points_m = 0.006;  // cloud points this near to the target's own surface are its own

  double clearance_share = 1;  // of the gripper's clearance, kept from other parts
  // Kept between hand and bin, whose place is known better than a part's.
  double bin_clearance_m = 0.002;
  // A hand that would meet the floor draws back until its contact is this near to the tips.
  double min_depth_m = 0.002;
  double good_depth_m = 0.008;  // contact this far behind the tips has no loss
  // Worse candidates are left alone: with true poses a third of what they held slipped out.
  double min_quality = 0.15;
  double voxel_m = 0.003;             // the cloud is thinned to
  double bin_band_m = 0.004;          // points this near to floor and walls are the bin's
  double neighbor_confidence = 0.5;   // believed poses from here on are obstacles
  double neighbor_spacing_m = 0.004;  // of the points on them
  // Poses are rivals for one part when they are nearer than both: this share of the diameter, and
  // this of the least extent, beyond which two parts can lie across each other.
  double same_share = 0.25;
  double same_thickness_share = 0.8;

  // Each lowers the score by up to its share: lowest part of all, approach at max_tilt_rad, nothing
  // but `clearance_m` of room, floor plan wholly covered by others, a hold with which the part
  // cannot be laid down, others between the fingers.
  double height_share = 0.4;
  double tilt_share = 0.4;
  double room_share = 0.4;
  double cover_share = 0.8;
  double set_down_share = 0.2;
  double between_share = 0.5;
  double aside_share = 0.3;      // by a hand that stands as far aside for a wall as it can
  double good_room_m = 0.010;    // distance from others from which there is no loss
  int many_between = 20;         // points of others between the fingers at which the loss is full
  double cover_above_m = 0.004;  // points this much higher lie on the target

  // How finely believed poses and the cloud are sampled; more is slower.
  double column_m = 0.010;  // of the floor plan that sorts the points
  int min_part_points = 200;
  int max_part_points = 2000;
  WiderLimits wide = {};
  void Visit(SettingsVisitor& v);
};

struct PlanResult {
  std::vector<Grasp> grasps;       // best first
  bool with_wider_limits = false;  // found, or looked for in vain, in the second look
  // Cause -> count, of the last look; with `grasps` they sum to the candidates of all poses.
  // Causes: tilt, quality, opening, bin floor, bin wall, fingers meet a part (a cup's stem too),
  // palm meets a part. The last two are looked for from the best candidate on, until no other can
  // come among the reported: "not tried" are those that were left then, "outranked" those that are
  // free but not among the best.
  std::map<std::string, int> rejected;
};

// Throws std::logic_error when a pose names an object outside `candidates` or `objects`, InputError
// for a ranking that is not known.
PlanResult PlanGrasps(const PlanInput& input, const PlanOptions& options = {});

}  // namespace pickbed
