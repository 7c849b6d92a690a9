#pragma once

// Interface notified after each stage of a trial, for images and replays.

#include <vector>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/pose_matching.h"
#include "eval/trial/stage_hash.h"
#include "eval/trial/trial.h"
#include "grasp/execute/motion_listener.h"
#include "grasp/gripper.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Data of an attempt up to the current stage.
struct AttemptState {
  BinIndex bin_index{0};  // random streams of the trial derive from it
  SimulatedCell& cell;
  const Gripper* gripper;             // from kGrasp on: the tool of the grasp
  const Scene& scene;                 // from kOutcome on: after the pick
  const AttemptRecord& record;        // with the hashes of the stages so far
  const Observation* view = nullptr;  // from kImage on
  const std::vector<ScoredHypothesis>* hypotheses = nullptr;  // from kHypotheses on
};

class TrialObserver {
 public:
  virtual ~TrialObserver() = default;
  // Called after each stage of each attempt, in order. kGrasp is also reported if no grasp was
  // found. An exception ends the trial.
  virtual void OnStage(TrialStage stage, const AttemptState& attempt) = 0;
  // Returns what to call after each step of the next execution, between kGrasp and kOutcome.
  // Default: nothing.
  virtual MotionListener ListenToMotion() { return {}; }
};

// Ends a stage of an attempt: stores its hash in `record` and notifies `observer`, if not null.
// `record` must be the record that attempt.record refers to.
void ReachStage(TrialStage stage, const AttemptState& attempt, AttemptRecord& record,
                TrialObserver* observer);

}  // namespace pickbed::eval
