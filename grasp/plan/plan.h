#pragma once

// Grasp planner. It moves the candidates of every estimated pose into the world, checks them for
// collisions and ranks them. It uses the bin and the observed cloud, never the ground truth.
//
// Other estimated poses represent the sides of neighbors that the camera cannot see. Their surfaces
// are obstacles like observed points.

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/plan/hidden_space.h"
#include "scenes/base/ids.h"
#include "scenes/base/settings.h"
#include "scenes/bin/bin.h"
#include "scenes/objects/object_model.h"
#include "scenes/scenario/failure_reason.h"

namespace pickbed::grasp {

// Estimated pose of an instance, from any source (ground truth, oracle, network, file).
struct EstimatedPose {
  ObjectId object{0};
  Pose X_WO = Pose::Identity();
  double confidence = 1;
};

// Input of the planner. References must outlive the call.
struct PlanInput {
  const Bin& bin;
  std::span<const EstimatedPose> poses;
  std::span<const std::vector<GraspCandidate>> candidates;  // by object
  std::span<const Eigen::Vector3d> cloud_W;  // observed points, with or without the bin
  const ObjectSet& objects;
  const Gripper& gripper;
  std::span<const int> targets = {};    // indices of poses that may be grasped; empty = all
  const HiddenSpace* hidden = nullptr;  // space that the image does not show; null = none
};

// Candidate measure by which grasps are ranked, in addition to pose confidence, height and free
// space.
struct RankingRow {
  const char* name;
  const char* help;
  double (*value)(const GraspCandidate& candidate);  // null = random order
  bool weighs_load = false;                          // PlanOptions::load_share applies
};
// Returns all rankings, in the order of the help.
std::span<const RankingRow> RankingTable();
// Returns the row with this name. Throws InputError that lists the known names.
const RankingRow& RankingNamed(const std::string& name);

// Relaxed constraints for a second pass if the first pass finds no grasp.
struct RelaxedConstraints {
  bool enabled = true;
  double max_tilt_rad = 1.3;
  double min_quality = 0.15;
  double clearance_share = 0.3;  // share of the clearance of the gripper
  double bin_clearance_m = 0.001;
  void Visit(SettingsVisitor& v);
};

// Constraints and score weights of the planner.
struct PlanOptions {
  int max_grasps = 5;               // maximum number of reported grasps
  std::string ranking = "quality";  // name of a row of RankingTable()
  uint64_t seed = 0;                // for the ranking "random"
  double max_tilt_rad = 1.05;       // of the approach from straight down
  double own_points_m = 0.006;  // cloud points this close to the surface of the target belong to it

  double clearance_share = 1;  // share of the gripper clearance that is kept from other instances
  // Distance between hand and bin. The pose of the bin is known better than instance poses.
  double bin_clearance_m = 0.002;
  // A hand that would meet the floor retracts, but the contact stays this far behind the tips.
  double min_depth_m = 0.002;
  double good_depth_m = 0.008;  // contact this far behind the tips: no loss
  // Worse candidates are ignored. With true poses, a third of the instances they held slipped out.
  double min_quality = 0.15;
  double voxel_m = 0.003;            // voxel size of the cloud
  double bin_band_m = 0.004;         // points this close to floor and walls belong to the bin
  double neighbor_confidence = 0.1;  // estimated poses with at least this confidence are obstacles
  static constexpr double kNoNeighbors =
      1e9;                            // confidence above every pose: no pose is an obstacle
  double neighbor_spacing_m = 0.004;  // spacing of the points on these poses
  // Two poses claim the same instance if they are closer than both limits: this share of the
  // diameter, and this share of the minimum extent. Instances that cross each other are further
  // apart than the second limit.
  double same_share = 0.25;
  double same_thickness_share = 0.8;

  // Maximum share of the score that each term can remove: lowest of all instances, approach at
  // max_tilt_rad, no free space around the hand, floor plan fully covered by others, a grasp from
  // which the object cannot be set down, others between the fingers.
  double height_share = 0.4;
  double tilt_share = 0.4;
  double room_share = 0.4;
  double cover_share = 0.8;
  double place_share = 0.2;
  // In the ranking "quality": share of the score that is lost if the contacts resist no load from
  // some direction (GraspCandidate::epsilon); half of it if they resist the weight. It makes the
  // qualities of jaws and suction cups comparable: a cup pulls an instance out that neighbors hold
  // less often.
  double load_share = 0.8;
  double between_share = 0.5;
  // Load at the start of the lift, in weights of the object. The weight comes on at once, which
  // makes about two. A hold that breaks under this load has half of the score.
  double lift_load = 2;
  double aside_share = 0.3;  // hand moved aside from a wall by the maximum distance
  // Share of the score that is lost if the fingers enter space that the image does not show, in the
  // mean over their cross-section by full_hidden_m or more. Unseen instances are there: with right
  // poses in deep bins, hands that entered it by over 8 mm met one in a quarter of the picks, and
  // hands that entered it by less than 4 mm in none of over 80.
  double hidden_share = 0.8;
  double full_hidden_m = 0.01;
  double hidden_behind_m = 0.005;  // what is less far behind a surface counts as seen
  double hidden_step_m = 0.004;    // spacing of the points at which the hand is tested
  double good_room_m = 0.010;      // distance from others from which there is no loss
  int many_between = 20;           // points of others between the fingers at full loss
  double cover_above_m = 0.004;    // points this much higher are on top of the target
  // Share of the score that each estimated pose above the target removes. With true poses in deep
  // bins, objects with 0, 1 and 2 others above slipped in 0.6, 4.5 and 12 % of 2553 picks.
  double stacking_share = 0.4;
  double stacking_cell_m = 0.005;  // cell size of the floor plan that shows which pose is above
  // A target under others is pulled out sideways, away from them: shift of the hand at the start of
  // the lift, in diameters of the target. 0 = always straight up.
  double lift_aside_diameters = 0.3;

  // Sampling density of estimated poses and the cloud; finer is slower.
  double column_m = 0.010;  // cell size of the floor-plan grid of the points
  int min_object_points = 200;
  int max_object_points = 2000;
  RelaxedConstraints relaxed = {};
  void Visit(SettingsVisitor& v);
};

// A planner that is a program failed for one image.
struct PlannerFailure {
  FailureReason reason = FailureReason::kPlannerCrashed;  // or kPlannerTimeout
  std::string text;                                       // one line
  std::vector<std::string> traceback;                     // the program's own report, by line
  bool is_malformed = false;                              // the answer broke the protocol
};

// Planned grasps and the reasons of rejection.
struct PlanResult {
  std::vector<Grasp> grasps;              // best first
  bool with_relaxed_constraints = false;  // the second pass ran, whether or not it found a grasp
  // Cause -> count in the last pass. Counts and `grasps` sum to the candidates of all poses.
  // Causes: tilt, quality, opening, bin floor, bin wall, fingers meet an instance (also the stem of
  // a cup), palm meets an instance. The last four are checked from the best candidate on, until no
  // other can be among the reported grasps. "not tried" counts the candidates not checked;
  // "outranked" counts free grasps that are not among the best.
  std::map<std::string, int> rejected;
  std::optional<PlannerFailure> failure;  // why a program gave no grasps
};

// Plans with each tool and returns the best grasps of all. `inputs` has one element per tool and
// differs in the gripper and its candidates. Constraints are relaxed if no tool has a grasp. The
// rejections are summed over the tools.
PlanResult PlanWithTools(std::span<const PlanInput> inputs, const PlanOptions& options = {});

// Plans grasps for the estimated poses; an empty list is a result. Throws std::logic_error if a
// pose names an object outside `candidates` or `objects`, and InputError for an unknown ranking.
PlanResult PlanGrasps(const PlanInput& input, const PlanOptions& options = {});

// Returns the number of targets for which PlanWithTools() would find a grasp if each were the only
// one, without relaxed constraints. They are tried in the order of the poses, until `wanted` are
// found. It is much cheaper than planning, since it stops at the first free grasp of a pose.
// `inputs` must not be empty. Throws as PlanGrasps() does.
int CountReachable(std::span<const PlanInput> inputs, int wanted, const PlanOptions& options = {});

}  // namespace pickbed::grasp
