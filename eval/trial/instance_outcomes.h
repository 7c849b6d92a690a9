#pragma once

// The outcome of each instance of a trial. Every instance was picked, was lost for one failure
// reason, or was not requested.

#include <vector>

#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/scenario/failure_reason.h"
#include "scenes/scene.h"

namespace pickbed::eval {

struct AttemptRecord;

// Outcome of one instance that is not a distractor.
struct InstanceOutcome {
  InstanceId instance{0};
  ObjectId object{0};
  bool picked = false;
  bool asked = true;  // false: it was left when the policy's number of picks was reached
  FailureReason failure = FailureReason::kNone;  // if requested and not picked
  int attempt = -1;                              // the attempt that decided it, -1 = none
  InstanceDeviation deviation = {};              // of friction and mass
  double size_deviation = 0;                     // against CAD, as a share
};

// How a trial ended; decides the outcome of the remaining instances.
struct TrialEnd {
  std::vector<InstanceId> remaining;  // instances in the bin
  bool gave_up = false;  // the last attempt's failure ended the trial, not the number of picks
};

// Decides the outcome of each instance. `outcomes` names the dropped instances that are not
// distractors; the function fills in the rest. `attempts` are in order.
// - An instance that left the bin was picked if a successful attempt delivered it. Otherwise it has
//   the failure of the attempt if it was the matched instance, kDoublePick or kEntangled if it came
//   along, else kNeighborDisplaced.
// - An instance that remains has the failure of the last failed attempt that matched it.
// - If failures ended the trial, the last attempt decides the other remaining instances. With a
//   grasp, they get its failure. Without one, they get the reason why they were not recalled, or
//   kNoGrasp if they were recalled.
// - If the number of picks ended the trial, each attempt requested one instance. A failed attempt
//   that matched none and lost none is attributed to one remaining instance: the most visible one
//   without a failure so far. The others were not requested.
// Throws std::logic_error if an instance is in no attempt, or remains but is not in the last one.
std::vector<InstanceOutcome> DecideOutcomes(std::vector<InstanceOutcome> outcomes,
                                            const std::vector<AttemptRecord>& attempts,
                                            const TrialEnd& end);

}  // namespace pickbed::eval
