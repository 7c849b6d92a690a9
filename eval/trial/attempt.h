#pragma once

// One attempt of a trial: capture, estimate, score against ground truth, choose a grasp, execute
// it, and attribute a failure to a stage.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "eval/trial/clutter.h"
#include "eval/trial/grasp_choice.h"
#include "eval/trial/instance_matcher.h"
#include "eval/trial/observer.h"
#include "eval/trial/pose_matching.h"
#include "eval/trial/trial_records.h"
#include "eval/trial/trial_setup.h"
#include "grasp/plan/image_picks.h"
#include "scenes/base/ids.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// An image, what was estimated from it, and the picks that used it so far.
struct CapturedImage {
  Observation view;
  InstanceMatcher truth;  // the scene at the time of the image
  std::vector<ScoredHypothesis> hypotheses;
  std::vector<InstanceRecord> instances;
  ImagePicks picks;
  FailureReason estimator_failure = FailureReason::kNone;  // of the program of the estimator
};

// State of a running trial. Every attempt reads the scene and replaces it by the scene after it.
struct LiveTrial {
  BinIndex bin_index{0};  // random streams derive from it
  ObjectSet objects;      // in their true sizes
  Scene scene;
  GraspMemory failed;
  std::shared_ptr<CapturedImage> image;  // the last one; null = none
  std::vector<int> layers;               // as in TrialResult
  GraspableCount graspable;              // the same
  StageSeconds seconds;
  TrialObserver* observer = nullptr;  // may be null
};

// Number of an attempt and, in an occlusion trial, the only instance that it may pick.
struct AttemptTask {
  int attempt = 0;
  InstanceId target = kNoInstance;  // instance, -1 = any
  int band = -1;                    // band of the target's visible fraction, -1 = none
  int stir = -1;         // number of the stir in its trial if no grasp is found, -1 = do not stir
  bool is_stir = false;  // no grasp is searched
};

// One attempt, stage by stage. It replaces trial.scene by the scene after the pick, adds the stage
// times to trial.seconds, remembers a failed grasp in trial.failed and notifies trial.observer.
class LiveAttempt {
 public:
  // Captures an image of trial.scene. `setup` and `trial` must outlive this object.
  LiveAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial);
  // Begins attempt number `attempt` with the image of the attempt before it, which succeeded.
  // Returns null, and changes only trial.seconds, if no planned grasp is independent of the earlier
  // picks of the image (grasp/plan/image_picks.h).
  static std::unique_ptr<LiveAttempt> WithLastImage(TrialSetup& setup, int attempt,
                                                    LiveTrial& trial);
  LiveAttempt(const LiveAttempt&) = delete;
  LiveAttempt& operator=(const LiveAttempt&) = delete;

  int number() const { return task_.attempt; }
  std::shared_ptr<const CapturedImage> image() const { return trial_.image; }

  // Estimates the poses in the image and compares them with ground truth. Returns the hypotheses.
  // Later calls return the same ones.
  const std::vector<ScoredHypothesis>& Estimate();
  // Chooses a grasp, after Estimate(); nullopt if there is none. Later calls return the same one.
  const std::optional<Grasp>& ChooseGrasp();

  // Returns whether `grasp` is the result of ChooseGrasp(), which must have been called.
  bool IsChosen(const std::optional<Grasp>& grasp) const;
  // Throws InputError if the grasp is for a hypothesis that was not estimated, with an unknown
  // tool, or wider than the tool opens.
  void RequireValid(const std::optional<Grasp>& grasp) const;

  // Executes a grasp, or stirs if there is none and the task allows it. Returns the record of the
  // attempt. Call it once.
  //
  // The grasp may be another one than the chosen one. One without a hypothesis is judged as a pick
  // without poses: by the instance that comes. The record then has no hypotheses. The same holds
  // for an attempt without an estimate. Throws as RequireValid().
  AttemptRecord Execute(const std::optional<Grasp>& grasp);

 private:
  struct LastImage {};
  LiveAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial, LastImage);
  void Plan();
  void LeaveOutPoses();
  void Reach(TrialStage stage);

  TrialSetup& setup_;
  const AttemptTask task_;
  LiveTrial& trial_;
  AttemptRecord record_;
  AttemptState state_;
  bool estimated_ = false;
  bool planned_ = false;
  std::optional<Grasp> chosen_;
};

// Runs one attempt with the grasp that the planner chooses.
AttemptRecord RunAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial);

// Returns the result of the scenario's estimator for an image of `attempt`, with ground truth in
// place of the stages that an oracle replaces. `truth`: the instances of the image.
EstimateResult EstimateInImage(TrialSetup& setup, const Observation& view,
                               const InstanceMatcher& truth, BinIndex bin_index, int attempt);

// Returns the seed of the planner for one attempt.
uint64_t PlanSeed(const TrialSetup& setup, BinIndex bin_index, int attempt);

}  // namespace pickbed::eval
