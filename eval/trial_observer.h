#pragma once

// Who wants to see the stages of a trial while it runs: pictures, replays.

#include <vector>

#include "eval/state_hash.h"
#include "eval/trial.h"
#include "eval/virtual_cell.h"
#include "grasp/gripper.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

// What is known of a look so far.
struct LookState {
  int scene_number = 0;  // of the trial; its random streams derive from it
  VirtualCell& cell;
  const GripperSpec& gripper;
  const Scene& scene;                                       // from kOutcome on: after the pick
  const PickRecord& record;                                 // with the hashes of the stages so far
  const View* view = nullptr;                               // from kImage on
  const std::vector<PoseHypothesis>* hypotheses = nullptr;  // from kHypotheses on
};

class TrialObserver {
 public:
  virtual ~TrialObserver() = default;
  // Each stage of each look, in order; the grasp also where none was found. What it throws ends the
  // trial.
  virtual void OnStage(TrialStage stage, const LookState& look) = 0;
};

// Whoever runs looks calls this when a stage is done: records its hash in `record`, which is the
// look's own, and tells the observer, if there is one.
void ReachStage(TrialStage stage, const LookState& look, PickRecord& record,
                TrialObserver* observer);

}  // namespace pickbed
