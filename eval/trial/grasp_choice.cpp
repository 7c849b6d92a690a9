#include "eval/trial/grasp_choice.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "eval/shapes/segment_shapes.h"
#include "grasp/plan/lift_clearance.h"
#include "grasp/planners/pose_planner.h"
#include "scenes/base/finite_counts.h"

namespace pickbed::eval {
namespace {

// Failed grasps within this distance are taken as failures of one instance, which comes after the
// others from so many failures on. The place of a hand says less about the instance than a pose.
constexpr double kSameInstance_m = 0.04;
constexpr int kFailuresWithPose = 1, kFailuresWithoutPose = 2;

PlanOptions RankedOptions(const TrialSetup& setup, uint64_t rng_seed) {
  PlanOptions plan;
  plan.ranking = setup.spec.policy.ranking;
  plan.seed = rng_seed;
  return plan;
}

// All estimated poses, and the indices of the poses that may be grasped.
struct PlannedPoses {
  std::vector<EstimatedPose> poses;
  std::vector<int> graspable;
};

PlannedPoses PosesOf(const AttemptRecord& record, double match_diameters) {
  PlannedPoses planned;
  for (const HypothesisRecord& hypothesis : record.hypotheses) {
    if (IsGraspable(hypothesis, record.target, match_diameters)) {
      planned.graspable.push_back(static_cast<int>(planned.poses.size()));
    }
    planned.poses.push_back(PoseOf(hypothesis));
  }
  return planned;
}

// Returns what the planner gets for an image.
PlannerInput InputOf(const TrialSetup& setup, const Observation& view,
                     std::span<const EstimatedPose> poses, std::span<const int> graspable,
                     int max_grasps, uint64_t rng_seed) {
  const CellCalibration& calibration = view.calibration;
  return {view.frame,
          calibration.camera.X_WC(),
          BinPlacement{setup.cell.bin(), calibration.X_WB.value_or(Pose::Identity())},
          poses,
          graspable,
          max_grasps,
          rng_seed};
}

// Removes the poses whose object would meet a wall while it is lifted. Returns the number of their
// grasp candidates.
int RemoveBlockedLifts(const TrialSetup& setup, const CellCalibration& calibration,
                       PlannedPoses& on) {
  const PolicySpec& policy = setup.spec.policy;
  if (!policy.check_lift) return 0;
  const Pose X_BW = calibration.X_WB ? calibration.X_WB->inverse() : Pose::Identity();
  int candidates = 0;
  std::erase_if(on.graspable, [&](int i) {
    const EstimatedPose& pose = on.poses[i];
    const ObjectModel& object = *setup.cell.objects()[pose.object];
    const bool meets =
        LiftMeetsWall(setup.cell.bin(), object, X_BW * pose.X_WO, 1e-3 * policy.lift_clearance_mm);
    if (!meets) return false;
    for (const auto& of_tool : setup.candidates) {
      candidates += static_cast<int>(of_tool[pose.object].size());
    }
    return true;
  });
  return candidates;
}

// Removes grasps that no planner should return.
void DropNotFinite(std::vector<Grasp>& grasps) {
  const auto dropped = std::erase_if(grasps, [](const Grasp& grasp) {
    return !grasp.X_WG.matrix().allFinite() || !std::isfinite(grasp.width_m) ||
           !std::isfinite(grasp.score);
  });
  CountNotFinite(FiniteBoundary::kGrasps, static_cast<int>(dropped));
}

// Calls the planner and leaves out grasps that are not finite or too weak.
PlanResult UsableGrasps(const TrialSetup& setup, const PlannerInput& input) {
  assert(std::ranges::all_of(
      input.poses, [](const EstimatedPose& pose) { return pose.X_WO.matrix().allFinite(); }));
  PlanResult plan = setup.planner->Plan(input);
  DropNotFinite(plan.grasps);
  const auto weak = std::erase_if(
      plan.grasps, [&](const Grasp& grasp) { return grasp.score < setup.spec.planner.min_score; });
  if (weak > 0) plan.rejected["score too low"] += static_cast<int>(weak);
  return plan;
}

// Returns the planned grasps, best first, without repetitions of failures.
std::vector<Grasp> PlanOnImage(const TrialSetup& setup, const TrueScene& truth,
                               const Observation& view, const PlannedPoses& on,
                               const GraspMemory& failed, const ImagePicks& earlier,
                               uint64_t rng_seed, AttemptRecord& record) {
  int max_grasps = PlanOptions().max_grasps;
  if (setup.options.truth.grasp) max_grasps = setup.options.true_grasps;
  if (!failed.empty() || !earlier.empty()) max_grasps = setup.options.retry_grasps;
  const TruthOfImage given(setup.shapes.get(), {truth.scene, truth.objects, view.ids});
  PlanResult plan =
      UsableGrasps(setup, InputOf(setup, view, on.poses, on.graspable, max_grasps, rng_seed));
  record.grasps_rejected = std::move(plan.rejected);
  record.planner_failure = std::move(plan.failure);
  std::vector<Grasp> fresh = failed.WithoutRepetitions(plan.grasps, on.poses, setup.options);
  if (fresh.size() < plan.grasps.size()) {
    record.grasps_rejected["failed before"] = static_cast<int>(plan.grasps.size() - fresh.size());
  }
  if (const int limit = setup.spec.policy.max_failures_at_place; limit > 0) {
    const auto given_up = std::erase_if(
        fresh, [&](const Grasp& grasp) { return failed.FailuresNear(grasp, on.poses) >= limit; });
    if (given_up > 0) {
      record.grasps_rejected["failed too often here"] = static_cast<int>(given_up);
    }
  }
  if (earlier.empty()) return fresh;
  const auto disturbing = std::erase_if(fresh, [&](const Grasp& grasp) {
    return !earlier.IsIndependent(grasp, on.poses[grasp.hypothesis],
                                  ToolNamed(setup.tools, grasp.tool));
  });
  if (disturbing > 0) {
    record.grasps_rejected["disturbs another pick"] = static_cast<int>(disturbing);
  }
  return fresh;
}

// Constraints are relaxed, since trying in the true scene shows what is free: no observed point and
// no other pose is an obstacle, and no approach is too flat. All lifts are straight up.
std::vector<Grasp> PlanRelaxed(const TrialSetup& setup, const Observation& view,
                               const PlannedPoses& on, const GraspMemory& failed,
                               uint64_t rng_seed) {
  PlanOptions relaxed = RankedOptions(setup, rng_seed);
  relaxed.max_grasps = setup.options.true_grasps;
  relaxed.max_tilt_rad = 0.5 * std::numbers::pi;
  relaxed.min_quality = 0;
  relaxed.bin_clearance_m = 0;
  relaxed.neighbor_confidence = PlanOptions::kNoNeighbors;
  const PosePlanner planner({setup.spec.planner, setup.tools, setup.cell.objects(),
                             setup.candidates, relaxed, setup.options.cloud_stride_px});
  const PlanResult plan = planner.PlanAmong(
      InputOf(setup, view, on.poses, on.graspable, relaxed.max_grasps, rng_seed), {}, relaxed);
  return failed.WithoutRepetitions(plan.grasps, on.poses, setup.options);
}

// Position by which a repetition is recognized: of the pose or, without one, of the hand.
Eigen::Vector3d PositionOf(const Grasp& grasp, const EstimatedPose* pose) {
  return pose != nullptr ? pose->X_WO.translation() : grasp.X_WG.translation();
}

std::optional<Grasp> FirstThatSucceeds(const TrialSetup& setup, const TrueScene& truth,
                                       const std::vector<Grasp>& grasps,
                                       const AttemptRecord& record) {
  const size_t tried = std::min<size_t>(grasps.size(), setup.options.true_grasps);
  for (size_t i = 0; i < tried; ++i) {
    if (TryGrasp(setup, truth, grasps[i], record.hypotheses, record.errors).outcome.success) {
      return grasps[i];
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<PlanInput> InputsOf(const TrialSetup& setup, std::span<const EstimatedPose> poses,
                                std::span<const Eigen::Vector3d> cloud_W,
                                std::span<const int> targets) {
  std::vector<PlanInput> inputs;
  for (size_t k = 0; k < setup.tools.size(); ++k) {
    inputs.push_back({setup.cell.bin(), poses, setup.candidates[k], cloud_W, setup.cell.objects(),
                      *setup.tools[k], targets});
  }
  return inputs;
}

void GraspMemory::Remember(const Grasp& grasp, const EstimatedPose* pose,
                           const GraspOutcome& outcome) {
  if (outcome.success) {
    for (FailedGrasp& old : failed_) old.picked_since = true;
    return;
  }
  failed_.push_back({pose != nullptr ? pose->object : kAnyObject, grasp.tool,
                     PositionOf(grasp, pose), grasp.X_WG.linear().col(2)});
}

std::vector<Grasp> GraspMemory::WithoutRepetitions(const std::vector<Grasp>& grasps,
                                                   const std::vector<EstimatedPose>& poses,
                                                   const TrialOptions& options) const {
  const auto repeats = [&](const Grasp& grasp, bool only_since_last_pick) {
    const EstimatedPose* pose =
        grasp.hypothesis == kNoHypothesis ? nullptr : &poses[grasp.hypothesis];
    const ObjectId object = pose != nullptr ? pose->object : kAnyObject;
    const Eigen::Vector3d position_W = PositionOf(grasp, pose);
    return std::any_of(failed_.begin(), failed_.end(), [&](const FailedGrasp& old) {
      const double cosine = old.approach_W.dot(grasp.X_WG.linear().col(2));
      return !(only_since_last_pick && old.picked_since) && old.object == object &&
             old.tool == grasp.tool &&
             (old.position_W - position_W).norm() < options.retry_radius_m &&
             std::acos(std::clamp(cosine, -1.0, 1.0)) < options.retry_angle_rad;
    });
  };
  const auto fresh_of = [&](bool only_since_last_pick) {
    std::vector<Grasp> fresh;
    for (const Grasp& grasp : grasps) {
      if (!repeats(grasp, only_since_last_pick)) fresh.push_back(grasp);
    }
    return fresh;
  };
  std::vector<Grasp> fresh = fresh_of(false);
  if (fresh.empty()) fresh = fresh_of(true);
  // Another grasp may hold an instance that failed. Other instances come first, because they may
  // cover it.
  std::stable_partition(fresh.begin(), fresh.end(), [&](const Grasp& grasp) {
    return FailuresNear(grasp, poses) <
           (grasp.hypothesis == kNoHypothesis ? kFailuresWithoutPose : kFailuresWithPose);
  });
  return fresh;
}

int GraspMemory::FailuresNear(const Grasp& grasp, const std::vector<EstimatedPose>& poses) const {
  const EstimatedPose* pose =
      grasp.hypothesis == kNoHypothesis ? nullptr : &poses[grasp.hypothesis];
  const ObjectId object = pose != nullptr ? pose->object : kAnyObject;
  const Eigen::Vector3d position_W = PositionOf(grasp, pose);
  const auto is_near = [&](const FailedGrasp& old) {
    return old.object == object && (old.position_W - position_W).norm() < kSameInstance_m;
  };
  return static_cast<int>(std::count_if(failed_.begin(), failed_.end(), is_near));
}

InstanceId MatchedInstance(const HypothesisRecord& hypothesis, double match_diameters) {
  return hypothesis.mssd_diameters() < match_diameters ? hypothesis.instance : kNoInstance;
}

bool IsGraspable(const HypothesisRecord& hypothesis, InstanceId target, double match_diameters) {
  return target < 0 || MatchedInstance(hypothesis, match_diameters) == target;
}

EstimatedPose PoseOf(const HypothesisRecord& hypothesis) {
  return {hypothesis.object, hypothesis.X_WO, hypothesis.score};
}

GraspTarget TargetOf(const HypothesisRecord* hypothesis, double match_diameters) {
  if (hypothesis == nullptr) return {};
  return {MatchedInstance(*hypothesis, match_diameters), hypothesis->object, hypothesis->X_WO};
}

const HypothesisRecord* HypothesisOf(const Grasp& grasp,
                                     const std::vector<HypothesisRecord>& hypotheses) {
  return grasp.hypothesis == kNoHypothesis ? nullptr : &hypotheses.at(grasp.hypothesis);
}

ExecuteResult TryGrasp(const TrialSetup& setup, const TrueScene& truth, const Grasp& grasp,
                       const std::vector<HypothesisRecord>& hypotheses, const AttemptErrors& errors,
                       const MotionListener& on_step) {
  GraspTarget target = TargetOf(HypothesisOf(grasp, hypotheses), setup.options.match_diameters);
  if (target.object >= 0) target.model = setup.cell.objects().at(target.object).get();
  return ExecuteWithErrors(truth, grasp, ToolNamed(setup.tools, grasp.tool), target, setup.execute,
                           errors, on_step);
}

PlanResult PlanInImage(const TrialSetup& setup, const Observation& view,
                       std::span<const EstimatedPose> poses, int max_grasps, uint64_t rng_seed) {
  return UsableGrasps(setup, InputOf(setup, view, poses, {}, max_grasps, rng_seed));
}

int CountReachable(const TrialSetup& setup, const Observation& view,
                   std::span<const PoseHypothesis> poses, int wanted) {
  const Pose& X_WC = view.calibration.camera.X_WC();
  std::vector<EstimatedPose> estimated;
  for (const PoseHypothesis& pose : poses) {
    estimated.push_back({pose.object, X_WC * pose.X_CO, pose.score});
  }
  std::vector<Eigen::Vector3d> cloud_W =
      ObservedPoints(view.frame, X_WC, setup.options.cloud_stride_px);
  if (view.calibration.X_WB) MoveToBin(*view.calibration.X_WB, estimated, cloud_W);
  return grasp::CountReachable(InputsOf(setup, estimated, cloud_W, {}), wanted,
                               RankedOptions(setup, 0));
}

std::optional<Grasp> ChooseGrasp(const TrialSetup& setup, const TrueScene& truth,
                                 const Observation& view, const GraspMemory& failed,
                                 const ImagePicks& earlier, uint64_t rng_seed,
                                 AttemptRecord& record, StageSeconds& seconds) {
  PlannedPoses on = PosesOf(record, setup.options.match_diameters);
  std::erase_if(on.graspable, [&](int pose) { return !earlier.IsApart(on.poses[pose]); });
  const int blocked = RemoveBlockedLifts(setup, view.calibration, on);
  const auto count_blocked = [&] {
    if (blocked > 0) record.grasps_rejected["held object meets a wall"] = blocked;
  };
  if (setup.has_poses && on.graspable.empty()) {
    count_blocked();
    return std::nullopt;
  }
  std::vector<Grasp> planned;
  {
    const StageTimer timer(seconds, "plan");
    planned = PlanOnImage(setup, truth, view, on, failed, earlier, rng_seed, record);
    count_blocked();
  }
  if (setup.options.truth.grasp) {
    const StageTimer timer(seconds, "try");
    if (const auto grasp = FirstThatSucceeds(setup, truth, planned, record)) return grasp;
    if (!earlier.empty()) return std::nullopt;  // a new image shows what is free
    if (!setup.has_poses) return planned.empty() ? std::nullopt : std::optional(planned.front());
    const std::vector<Grasp> relaxed = PlanRelaxed(setup, view, on, failed, rng_seed);
    if (const auto grasp = FirstThatSucceeds(setup, truth, relaxed, record)) return grasp;
  }
  return planned.empty() ? std::nullopt : std::optional(planned.front());
}

StirPath ChooseStir(const Bin& bin, const Gripper& tool, const Observation& view, int number) {
  constexpr int kStride_px = 2;  // the plan thins the points to voxels
  std::vector<EstimatedPose> no_poses;
  std::vector<Eigen::Vector3d> cloud_W =
      ObservedPoints(view.frame, view.calibration.camera.X_WC(), kStride_px);
  if (view.calibration.X_WB) MoveToBin(*view.calibration.X_WB, no_poses, cloud_W);
  StirPath path = PlanStir(bin, cloud_W, tool, number);
  if (!view.calibration.X_WB) return path;
  path.X_WG_from = *view.calibration.X_WB * path.X_WG_from;
  path.X_WG_to = *view.calibration.X_WB * path.X_WG_to;
  return path;
}

}  // namespace pickbed::eval
