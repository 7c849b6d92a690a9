#include "eval/trial/instance_outcomes.h"

#include <algorithm>
#include <stdexcept>

#include "eval/trial/trial.h"

namespace pickbed::eval {
namespace {

const InstanceRecord* SeenIn(const AttemptRecord& attempt, InstanceId instance) {
  const auto found = std::find_if(
      attempt.instances.begin(), attempt.instances.end(),
      [instance](const InstanceRecord& record) { return record.instance == instance; });
  return found == attempt.instances.end() ? nullptr : &*found;
}

// Fills in the outcome of an instance that left the bin in this attempt.
void LeaveBy(const AttemptRecord& attempt, InstanceOutcome& instance_outcome) {
  instance_outcome.attempt = attempt.attempt;
  const GraspOutcome& outcome = attempt.outcome;
  const bool brought = outcome.picked_instance == instance_outcome.instance;
  instance_outcome.picked = attempt.failure == FailureReason::kNone && brought;
  if (instance_outcome.picked) return;
  const bool is_entangled = outcome.failure == FailureReason::kEntangled;
  const bool in_hand = outcome.failure == FailureReason::kDoublePick || is_entangled || brought;
  const bool is_target = attempt.matched_instance == instance_outcome.instance &&
                         attempt.failure != FailureReason::kNone;
  instance_outcome.failure = is_target      ? attempt.failure
                             : is_entangled ? FailureReason::kEntangled
                             : in_hand      ? FailureReason::kDoublePick
                                            : FailureReason::kNeighborDisplaced;
}

// A failed attempt without an attributed instance also requested one. Otherwise a bin whose poses
// match nothing would request fewer instances than a bin with correct poses.
void AttributeAttemptsWithoutTarget(const std::vector<AttemptRecord>& attempts,
                                    std::vector<InstanceOutcome>& outcomes) {
  for (const AttemptRecord& attempt : attempts) {
    if (attempt.failure == FailureReason::kNone || attempt.matched_instance >= 0) continue;
    const bool is_attributed =
        std::any_of(outcomes.begin(), outcomes.end(), [&](const InstanceOutcome& instance_outcome) {
          return instance_outcome.attempt == attempt.attempt && !instance_outcome.picked;
        });
    if (is_attributed) continue;
    InstanceOutcome* best_seen = nullptr;
    double maximum = -1;
    for (InstanceOutcome& instance_outcome : outcomes) {
      const InstanceRecord* seen =
          instance_outcome.asked ? nullptr : SeenIn(attempt, instance_outcome.instance);
      if (seen == nullptr || seen->visible_fraction <= maximum) continue;
      maximum = seen->visible_fraction;
      best_seen = &instance_outcome;
    }
    if (best_seen == nullptr) continue;
    best_seen->asked = true;
    best_seen->failure = attempt.failure;
    best_seen->attempt = attempt.attempt;
  }
}

void Remain(const std::vector<AttemptRecord>& attempts, bool gave_up,
            InstanceOutcome& instance_outcome) {
  for (auto attempt = attempts.rbegin(); attempt != attempts.rend(); ++attempt) {
    if (attempt->matched_instance != instance_outcome.instance ||
        attempt->failure == FailureReason::kNone)
      continue;
    instance_outcome.failure = attempt->failure;
    instance_outcome.attempt = attempt->attempt;
    return;
  }
  instance_outcome.asked = gave_up;
  if (!gave_up) return;
  const AttemptRecord& last = attempts.back();
  instance_outcome.attempt = last.attempt;
  if (last.grasp) {
    instance_outcome.failure = last.failure;
    return;
  }
  const FailureReason missed = SeenIn(last, instance_outcome.instance)->missed;
  instance_outcome.failure = missed == FailureReason::kNone ? FailureReason::kNoGrasp : missed;
}

}  // namespace

std::vector<InstanceOutcome> DecideOutcomes(std::vector<InstanceOutcome> outcomes,
                                            const std::vector<AttemptRecord>& attempts,
                                            const TrialEnd& end) {
  for (InstanceOutcome& instance_outcome : outcomes) {
    const auto& remaining = end.remaining;
    const bool remains =
        std::find(remaining.begin(), remaining.end(), instance_outcome.instance) != remaining.end();
    const auto last =
        std::find_if(attempts.rbegin(), attempts.rend(), [&](const AttemptRecord& attempt) {
          return SeenIn(attempt, instance_outcome.instance) != nullptr;
        });
    if (last == attempts.rend() || (remains && last != attempts.rbegin())) {
      throw std::logic_error("an instance is in the bin that no attempt recorded");
    }
    if (remains) {
      Remain(attempts, end.gave_up, instance_outcome);
    } else {
      LeaveBy(*last, instance_outcome);
    }
  }
  if (!end.gave_up) AttributeAttemptsWithoutTarget(attempts, outcomes);
  return outcomes;
}

}  // namespace pickbed::eval
