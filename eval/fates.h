#pragma once

// What became of each part of a trial, so that every part is picked, or lost for one reason, or was
// not asked for.

#include <vector>

#include "scenes/loss.h"

namespace pickbed {

struct PickRecord;

struct InstanceFate {
  int instance = 0;
  int object = 0;
  bool picked = false;
  bool asked = true;        // false: it lay there when the policy's number of picks was reached
  Loss loss = Loss::kNone;  // of one that was asked for and not picked
  int pick = -1;            // the look that decided it, -1 = none
};

// How a trial ended, for those that remain.
struct TrialEnd {
  std::vector<int> remaining;  // instances in the bin
  bool gave_up = false;        // the last look's loss ended it, not the policy's number of picks
};

// `fates` names the wanted parts that were dropped; the rest is filled in, from the looks in order:
// - A part that left the bin was picked when that is what the pick brought. Else the loss of the
//   pick stands when the part was its aim, kTookTwo when it came along in the hand, and kDisturbed
//   when neither is so.
// - A part that remains is charged to the last pick that aimed at it. When failed picks ended the
//   trial, one that was never aimed at is charged to the last of them; when a look without a grasp
//   did, to why that look had no right pose of it, and to kNoGrasp where there was one.
// - When the policy's number of picks ended the trial, each look had asked for one part. One that
//   failed, aimed at none and cost the bin none is charged with the part that it saw most of, of
//   those that remain and that nothing else is charged with. The others were not asked for.
// Throws std::logic_error when a part both remains and is not in the last look.
std::vector<InstanceFate> FatesOf(std::vector<InstanceFate> fates,
                                  const std::vector<PickRecord>& picks, const TrialEnd& end);

}  // namespace pickbed
