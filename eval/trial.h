#pragma once

// One trial: drop, then look, estimate, refine, pick, score, again and again until the bin is empty
// or the scenario's policy ends it (scenes/policy.h). Where the scenario asks for it, an occlusion
// trial in its place: one target, seen and picked once in each band of its visible fraction
// (scenes/occlusion_spec.h); a pick then leaves no trace in the next look.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/fates.h"
#include "eval/state_hash.h"
#include "eval/truth_feed.h"
#include "grasp/execute.h"
#include "grasp/plan.h"
#include "perception/pose_estimator.h"
#include "scenes/scenario_spec.h"
#include "scenes/scene.h"
#include "sim/occlusion_maker.h"
#include "sim/renderer.h"
#include "sim/scene_maker.h"
#include "sim/sensor_profile.h"

namespace pickbed {

class TrialObserver;

// One hypothesis against the truth; errors in metres, pixels and radians.
struct HypothesisScore {
  int object = 0;
  int instance = -1;  // true instance it was matched to, -1 = none
  double score = 0;
  double mssd_m = 0, mspd_px = 0, add_m = 0, adi_m = 0, rotation_rad = 0, translation_m = 0;
  double mssd_diameters = 0;
  bool correct = false;                      // MSSD < 0.1 diameter
  Pose X_WO = Pose::Identity();              // as believed
  Pose X_OtrueObelieved = Pose::Identity();  // the believed part in that instance
};

struct InstanceRecord {
  int instance = 0;
  int object = 0;
  double visible_fraction = 0;
  bool recalled = false;      // some hypothesis is correct for it
  Loss missed = Loss::kNone;  // why it is not recalled, see WhyMissed in eval/blame.h
};

// One look, and the pick that followed from it. A look without an executed grasp is no attempt: its
// `grasp` is empty and `loss` says why none was made (kNone when none was wanted).
struct PickRecord {
  int pick = 0;
  std::vector<InstanceRecord> instances;
  std::vector<HypothesisScore> hypotheses;
  int chosen = -1;  // hypothesis of the executed grasp
  int aimed = -1;   // instance that it stands on, -1 = none
  int target = -1;  // instance that the look of an occlusion sweep is about, -1 = none
  int band = -1;    // band of the target's visible fraction, -1 = none
  std::optional<Grasp> grasp;
  GraspOutcome outcome;
  Loss loss = Loss::kNone;
  std::map<std::string, int> grasps_rejected;
  StageHashes hashes;
};

struct TrialResult {
  int trial = 0;  // number in its results store
  int point = 0;  // point of the sweep that it belongs to, 0 in a plain run
  int scene = 0;  // which scene it is about: equal for the trials of several points that are pairs
  SceneCertificate certificate;
  std::vector<RefusedScene> refused;  // before the certified one
  int parts_dropped = 0;
  int parts_cleared = 0;  // by picks that succeeded; a part knocked out of the bin is not one
  std::vector<InstanceFate> fates;  // of each part that was dropped and wanted
  std::vector<PickRecord> picks;
  // Of an occlusion trial, by band; else empty.
  std::vector<BandAccount> bands;
  Loss ended_by = Loss::kNone;  // kNone = bin empty or pick limit, else what stopped the trial
  StageSeconds seconds;         // never part of a results file
};

// How the runner chooses among planned grasps.
struct TrialOptions {
  // After a failed pick a grasp on the same part is not tried again when the believed position is
  // within `retry_radius_m` of the failed one and the approach within `retry_angle_rad`: an
  // unchanged bin would give the same failure. Once another part has been picked it comes last.
  double retry_radius_m = 0.02;
  double retry_angle_rad = 0.35;
  int retry_grasps = 200;            // planned after a failure, to choose from
  int cloud_stride_px = 2;           // of the observed points that the planner keeps clear of
  double stands_on_diameters = 0.5;  // MSSD within which a hypothesis stands on an instance
  TruthStages truth;                 // stages that are fed with truth
  int true_grasps = 10;              // tried in the true scene where truth.grasp is set
};

// What a worker holds for all its trials: meshes on the renderer, network, grasp candidates.
class TrialRunner {
 public:
  // Called while code books are made and after each pick: what, and the share that is done.
  using Progress = std::function<void(std::string_view what, double share)>;

  // Makes the estimator and grasp candidates, from caches where they hold them. Throws InputError
  // for an unknown estimator, gripper, sensor or policy and for a broken model file.
  TrialRunner(const ScenarioSpec& spec, const ObjectSet& objects, const Progress& on_progress = {},
              const TrialOptions& options = {});
  ~TrialRunner();

  // The trial of that scene number, which is also the trial's until the caller numbers it.
  // `observer`, when there is one, sees each stage of each look.
  TrialResult Run(int scene, TrialObserver* observer = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
