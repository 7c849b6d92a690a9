#pragma once

// Chooses the grasp of an attempt: plans on the estimated poses or, without a pose stage, on the
// image; leaves out grasps that failed before, and tries grasps in the true scene where the stage
// oracle asks for it.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/trial/trial_records.h"
#include "eval/trial/trial_setup.h"
#include "grasp/plan/image_picks.h"
#include "grasp/plan/plan.h"
#include "grasp/plan/plan_stir.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// The failed grasps of a trial, so that they are not repeated in an unchanged bin.
class GraspMemory {
 public:
  // Remembers a failed grasp. After a successful one, older failures become a last choice, since
  // the way may be clear now. `pose`: the estimated pose, null for a grasp without one.
  void Remember(const Grasp& grasp, const EstimatedPose* pose, const GraspOutcome& outcome);
  // Returns the grasps that do not repeat a failure, in the given order. If all of them repeat one,
  // returns the grasps that repeat only failures from before a later successful pick. A grasp with
  // a pose repeats a failure if the object and its estimated position are the same. A grasp without
  // a pose repeats it if its own origin in the world is near. Grasps of an instance that failed
  // come last: those with a pose near a failure, and those without a pose near two.
  std::vector<Grasp> WithoutRepetitions(const std::vector<Grasp>& grasps,
                                        const std::vector<EstimatedPose>& poses,
                                        const TrialOptions& options) const;
  // Returns the number of failed grasps within 40 mm of a grasp: between the poses of two instances
  // of one object or, without poses, between the hands.
  int FailuresNear(const Grasp& grasp, const std::vector<EstimatedPose>& poses) const;
  bool empty() const { return failed_.empty(); }
  void Clear() { failed_.clear(); }

 private:
  struct FailedGrasp {
    ObjectId object{0};
    std::string tool;
    Eigen::Vector3d position_W = Eigen::Vector3d::Zero();
    Eigen::Vector3d approach_W = Eigen::Vector3d::UnitZ();
    bool picked_since = false;  // another instance was picked after the failure
  };
  std::vector<FailedGrasp> failed_;
};

// Returns the instance that a hypothesis matches (MSSD < match_diameters diameters), -1 = none.
InstanceId MatchedInstance(const HypothesisRecord& hypothesis, double match_diameters);

// Returns whether a hypothesis may be grasped: with a target, only if it matches it.
bool IsGraspable(const HypothesisRecord& hypothesis, InstanceId target, double match_diameters);

// Returns the estimated pose in the world.
EstimatedPose PoseOf(const HypothesisRecord& hypothesis);

// Returns the target of a grasp on a hypothesis. Without a pose (null) any instance is the target.
GraspTarget TargetOf(const HypothesisRecord* hypothesis, double match_diameters);

// Returns the hypothesis of a grasp, or null if it was planned without poses.
const HypothesisRecord* HypothesisOf(const Grasp& grasp,
                                     const std::vector<HypothesisRecord>& hypotheses);

// Executes a grasp on one of the hypotheses, or on none, in the true scene, which does not change,
// with the errors of the attempt, and returns the scene after it. `on_step` is called after each
// step of the physics.
ExecuteResult TryGrasp(const TrialSetup& setup, const TrueScene& truth, const Grasp& grasp,
                       const std::vector<HypothesisRecord>& hypotheses, const AttemptErrors& errors,
                       const MotionListener& on_step = {});

// Returns the inputs of the planner, one per tool, in the frame of the bin that the cell assumes.
// They refer to the arguments, which must outlive them. Empty `targets` = all poses.
std::vector<PlanInput> InputsOf(const TrialSetup& setup, std::span<const EstimatedPose> poses,
                                std::span<const Eigen::Vector3d> cloud_W,
                                std::span<const int> targets);

// Returns how many of the poses have a grasp that is free of the bin, the observed points and the
// other poses; it stops counting at `wanted`. The poses have the object indices of the cell.
int CountReachable(const TrialSetup& setup, const Observation& view,
                   std::span<const PoseHypothesis> poses, int wanted);

// Returns the planned grasps on the poses or, with a planner without poses, in the image; best
// first. Grasps under planner.min_score and grasps that are not finite are left out. `rng_seed` is
// the planner's seed.
PlanResult PlanInImage(const TrialSetup& setup, const Observation& view,
                       std::span<const EstimatedPose> poses, int max_grasps, uint64_t rng_seed);

// Returns the grasp to execute on one of record.hypotheses or, without a pose stage, anywhere in
// the image; nullopt if there is none. Fills record.grasps_rejected and adds the times to
// `seconds`. `rng_seed` is the planner's seed. The grasp is independent of the `earlier` picks of
// the same image.
std::optional<Grasp> ChooseGrasp(const TrialSetup& setup, const TrueScene& truth,
                                 const Observation& view, const GraspMemory& failed,
                                 const ImagePicks& earlier, uint64_t rng_seed,
                                 AttemptRecord& record, StageSeconds& seconds);

// Returns the path of the hand in the world with which the bin is stirred, planned from the
// observed points in the bin that the cell assumes. `number`: of the stir in its trial.
StirPath ChooseStir(const Bin& bin, const Gripper& tool, const Observation& view, int number);

}  // namespace pickbed::eval
