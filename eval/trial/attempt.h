#pragma once

// One attempt of a trial: capture, estimate, score against ground truth, choose a grasp, execute
// it, and attribute a failure to a stage.

#include <optional>
#include <vector>

#include "eval/trial/clutter.h"
#include "eval/trial/grasp_choice.h"
#include "eval/trial/instance_matcher.h"
#include "eval/trial/pose_matching.h"
#include "eval/trial/trial_records.h"
#include "eval/trial/trial_setup.h"
#include "grasp/plan/image_picks.h"
#include "scenes/base/ids.h"
#include "scenes/scene.h"

namespace pickbed::eval {

class TrialObserver;

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
  std::optional<CapturedImage> image;  // the last one
  std::vector<int> layers;             // as in TrialResult
  GraspableCount graspable;            // the same
  StageSeconds seconds;
  TrialObserver* observer = nullptr;  // may be null
};

// Number of an attempt and, in an occlusion trial, the only instance that it may pick.
struct AttemptTask {
  int attempt = 0;
  InstanceId target = kNoInstance;  // instance, -1 = any
  int band = -1;                    // band of the target's visible fraction, -1 = none
  int stir = -1;  // number of the stir in its trial if no grasp is found, -1 = do not stir
};

// Runs one attempt on trial.scene and replaces the scene by the one after the pick. Adds the stage
// times to trial.seconds, remembers a failed grasp in trial.failed and notifies trial.observer.
AttemptRecord RunAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial);

// Runs attempt number `attempt` with the image of the attempt before it, which succeeded. Returns
// nullopt, and changes only trial.seconds, if no planned grasp is independent of the earlier picks
// of the image (grasp/plan/image_picks.h).
std::optional<AttemptRecord> RunFurtherPick(TrialSetup& setup, int attempt, LiveTrial& trial);

}  // namespace pickbed::eval
