#include "eval/fates.h"

#include <algorithm>
#include <stdexcept>

#include "eval/trial.h"

namespace pickbed {
namespace {

const InstanceRecord* SeenIn(const PickRecord& pick, int instance) {
  const auto found = std::find_if(
      pick.instances.begin(), pick.instances.end(),
      [instance](const InstanceRecord& record) { return record.instance == instance; });
  return found == pick.instances.end() ? nullptr : &*found;
}

// How a part left the bin by a pick.
void LeaveBy(const PickRecord& pick, InstanceFate& fate) {
  fate.pick = pick.pick;
  const GraspOutcome& outcome = pick.outcome;
  const bool brought = outcome.picked_instance == fate.instance;
  fate.picked = pick.loss == Loss::kNone && brought;
  if (fate.picked) return;
  const bool in_hand = outcome.loss == Loss::kTookTwo || brought;
  const bool aim = pick.aimed == fate.instance && pick.loss != Loss::kNone;
  fate.loss = aim ? pick.loss : in_hand ? Loss::kTookTwo : Loss::kDisturbed;
}

// Each look that failed without a part to be charged with asked for one all the same: else a bin
// whose poses stand on nothing would ask for less than one whose poses are true.
void ChargeAimlessLooks(const std::vector<PickRecord>& picks, std::vector<InstanceFate>& fates) {
  for (const PickRecord& pick : picks) {
    if (pick.loss == Loss::kNone || pick.aimed >= 0) continue;
    const bool is_charged = std::any_of(fates.begin(), fates.end(), [&](const InstanceFate& fate) {
      return fate.pick == pick.pick && !fate.picked;
    });
    if (is_charged) continue;
    InstanceFate* most_seen = nullptr;
    double most = -1;
    for (InstanceFate& fate : fates) {
      const InstanceRecord* seen = fate.asked ? nullptr : SeenIn(pick, fate.instance);
      if (seen == nullptr || seen->visible_fraction <= most) continue;
      most = seen->visible_fraction;
      most_seen = &fate;
    }
    if (most_seen == nullptr) continue;
    most_seen->asked = true;
    most_seen->loss = pick.loss;
    most_seen->pick = pick.pick;
  }
}

void Remain(const std::vector<PickRecord>& picks, bool gave_up, InstanceFate& fate) {
  for (auto pick = picks.rbegin(); pick != picks.rend(); ++pick) {
    if (pick->aimed != fate.instance || pick->loss == Loss::kNone) continue;
    fate.loss = pick->loss;
    fate.pick = pick->pick;
    return;
  }
  fate.asked = gave_up;
  if (!gave_up) return;
  const PickRecord& last = picks.back();
  fate.pick = last.pick;
  if (last.grasp) {
    fate.loss = last.loss;
    return;
  }
  const Loss missed = SeenIn(last, fate.instance)->missed;
  fate.loss = missed == Loss::kNone ? Loss::kNoGrasp : missed;
}

}  // namespace

std::vector<InstanceFate> FatesOf(std::vector<InstanceFate> fates,
                                  const std::vector<PickRecord>& picks, const TrialEnd& end) {
  for (InstanceFate& fate : fates) {
    const auto& remaining = end.remaining;
    const bool remains =
        std::find(remaining.begin(), remaining.end(), fate.instance) != remaining.end();
    const auto last = std::find_if(picks.rbegin(), picks.rend(), [&](const PickRecord& pick) {
      return SeenIn(pick, fate.instance) != nullptr;
    });
    if (last == picks.rend() || (remains && last != picks.rbegin())) {
      throw std::logic_error("a part lies in the bin that no look could see");
    }
    if (remains) {
      Remain(picks, end.gave_up, fate);
    } else {
      LeaveBy(*last, fate);
    }
  }
  if (!end.gave_up) ChargeAimlessLooks(picks, fates);
  return fates;
}

}  // namespace pickbed
