#pragma once

// Records of a trial: plain data, filled by the stages of eval/trial/attempt.h and stored by
// eval/store. A trial is one bin, from the drop to the end of picking. An attempt is one image and
// what follows.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/cell/cell_errors.h"
#include "eval/metrics/metric_values.h"
#include "eval/trial/instance_outcomes.h"
#include "eval/trial/stage_hash.h"
#include "grasp/grasp.h"
#include "grasp/plan/plan.h"
#include "scenes/base/ids.h"
#include "scenes/base/stage_timer.h"
#include "scenes/scenario/failure_reason.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/occlusion_series.h"

namespace pickbed::eval {

// A hypothesis compared with ground truth.
struct HypothesisRecord {
  ObjectId object{0};
  InstanceId instance = kNoInstance;  // matched true instance, -1 = none
  double score = 0;
  double raw_score = 0;          // of the estimator, before its calibration
  MetricValues metrics;          // pose errors, infinite without a matched instance
  bool correct = false;          // MSSD < kCorrectDiameters
  Pose X_WO = Pose::Identity();  // estimated pose in the world, by the calibration of the cell
  // Estimated object frame E in the frame of the matched instance. It contains the hand-eye error;
  // the metrics do not, since they judge the estimator.
  Pose X_OE = Pose::Identity();

  double mssd_m() const { return metrics.Get(kMssd_m); }
  double mssd_diameters() const { return metrics.Get(kMssdDiameters); }
  double rotation_rad() const { return metrics.Get(kRotation_rad); }
  double translation_m() const { return metrics.Get(kTranslation_m); }
};

// A true instance in the image.
struct InstanceRecord {
  InstanceId instance{0};
  ObjectId object{0};
  double visible_fraction = 0;
  bool recalled = false;                        // some hypothesis is correct for it
  FailureReason missed = FailureReason::kNone;  // why it is not recalled; see MissReasons
};

// A cause of rejected grasps (grasp/plan/plan.h) that had another name in earlier versions.
struct RenamedCause {
  std::string_view was, is;
};
inline constexpr RenamedCause kRenamedCauses[] = {
    {"fingers meet a part", "fingers meet an instance"},
    {"palm meets a part", "palm meets an instance"}};

// A stage of the timings whose name has changed. Stored trials can have the former one.
struct RenamedStage {
  std::string_view was, is;
};
inline constexpr RenamedStage kRenamedStages[] = {
    {"see", "capture"},
    {"estimate/look_alikes", "estimate/ambiguous_poses"},
    {"estimate/suppress", "estimate/non_maximum_suppression"}};

// A pick and the image that it used. Without an executed grasp `grasp` is empty, and `failure` is
// the reason (kNone if no grasp was requested).
struct AttemptRecord {
  int attempt = 0;  // number in its trial
  // Number of picks before this one that used the same image. `instances` and `hypotheses` of these
  // picks are from one estimate, so statistics of images count them only in the first.
  int pick_of_image = 0;
  // The planner worked without poses: there was no pose stage, so `hypotheses` is empty and no
  // instance can be recalled.
  bool pose_free = false;
  std::vector<InstanceRecord> instances;
  std::vector<HypothesisRecord> hypotheses;
  int chosen = -1;  // hypothesis of the executed grasp, -1 = none
  // Matches the chosen hypothesis; without poses, the instance that came or was nearest; -1 =
  // none.
  InstanceId matched_instance = kNoInstance;
  InstanceId target = kNoInstance;  // target instance of an occlusion trial, -1 = none
  int band = -1;                    // band of the target's visible fraction, -1 = none
  std::optional<Grasp> grasp;       // as planned
  // Why the program of the planner gave no grasps. It is not stored, because `failure` names it.
  std::optional<PlannerFailure> planner_failure;
  // Fill level of the bin before the pick, 0 = empty, and the place of the matched instance in it
  // (sim/drop/fill_level.h). Negative, or layer 0: unknown.
  double fill_level = -1;
  int layer = 0;  // 1 = top
  int instances_above = -1, instances_below = -1;
  AttemptErrors errors;  // of the execution
  GraspOutcome outcome;
  FailureReason failure = FailureReason::kNone;
  std::map<std::string, int> grasps_rejected;  // cause -> number of candidates
  StageHashes hashes;

  bool has_own_image() const { return pick_of_image == 0; }
};

// Returns whether the attempt found no grasp and stirred the bin. Its physics may have failed.
inline bool Stirred(const AttemptRecord& attempt) {
  return !attempt.grasp && (attempt.failure == FailureReason::kStirred ||
                            attempt.failure == FailureReason::kPhysicsFailed);
}

// Returns whether the hand moved in the bin: it executed a grasp, or stirred. Only these attempts
// count in the success rate and cost a motion.
inline bool UsedHand(const AttemptRecord& attempt) {
  return attempt.grasp.has_value() || Stirred(attempt);
}

struct TrialResult {
  int trial = 0;          // number in its results store
  int configuration = 0;  // of the sweep, 0 in a plain run
  BinIndex bin_index{0};  // equal for the paired trials of several configurations
  BinErrors errors;
  SceneCertificate certificate;
  std::vector<RefusedScene> refused;  // before the certified one
  int instances_dropped = 0;
  int instances_cleared =
      0;  // by successful picks; an instance pushed out of the bin does not count
  // State before the first pick (eval/trial/clutter.h); not of an occlusion trial.
  std::vector<int> layers;      // number of instances in each layer, from the top; empty = unknown
  int instances_tested = 0;     // instances of the first image tested for a grasp
  int instances_graspable = 0;  // tested instances with a grasp that meets nothing
  std::vector<InstanceOutcome> outcomes;  // of each dropped instance that is not a distractor
  std::vector<AttemptRecord> attempts;
  std::vector<BandAccount> bands;  // of an occlusion trial, else empty
  // kNone if the bin is empty or the number of picks is reached, else what ended the trial.
  FailureReason ended_by = FailureReason::kNone;
  StageSeconds seconds;  // never part of a results file
};

}  // namespace pickbed::eval
