#include "eval/trial/failure_attribution.h"

#include <algorithm>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/grasp_choice.h"

namespace pickbed::eval {
namespace {

// Returns the reason why a hypothesis is wrong: the last stage that had a correct pose for it.
FailureReason MakerOf(const ScoredHypothesis& wrong, const InstanceMatcher& truth) {
  const PoseHypothesis& estimate = wrong.estimate;
  const auto right = [&](const Pose& X_CO) { return truth.IsCorrect(estimate.object, X_CO); };
  if (estimate.unrefined_X_CO && right(*estimate.unrefined_X_CO))
    return FailureReason::kRefinementWorse;
  const auto& suppressed = estimate.suppressed_X_CO;
  if (std::any_of(suppressed.begin(), suppressed.end(), right)) return FailureReason::kSuppressed;
  const bool own_kind =
      wrong.nearest >= 0 && truth.instances()[wrong.nearest].object == estimate.object;
  return own_kind ? FailureReason::kPoseWrong : FailureReason::kWrongObject;
}

FailureReason MissReason(const InstanceMatcher& truth, int position,
                         const std::vector<ScoredHypothesis>& hypotheses) {
  const auto right = [&](ObjectId object, const Pose& X_CO) {
    return truth.IsCorrectFor(position, object, X_CO);
  };
  for (const ScoredHypothesis& h : hypotheses) {
    const PoseHypothesis& estimate = h.estimate;
    if (estimate.unrefined_X_CO && right(estimate.object, *estimate.unrefined_X_CO))
      return FailureReason::kRefinementWorse;
  }
  FailureReason missed = FailureReason::kNoProposal;
  for (const ScoredHypothesis& h : hypotheses) {
    for (const Pose& X_CO : h.estimate.suppressed_X_CO) {
      if (right(h.estimate.object, X_CO)) return FailureReason::kSuppressed;
    }
    if (h.nearest != position) continue;
    const bool own_kind = h.estimate.object == truth.instances()[position].object;
    if (own_kind) missed = FailureReason::kPoseWrong;
    if (!own_kind && missed == FailureReason::kNoProposal) missed = FailureReason::kWrongObject;
  }
  return missed;
}

bool AnyVisible(const AttemptRecord& record) {
  return std::any_of(record.instances.begin(), record.instances.end(),
                     [](const InstanceRecord& instance) {
                       return instance.visible_fraction >= kCountedVisibility;
                     });
}

// Without a pose, the physical outcome is the reason.
FailureReason FailureWithoutPoses(const AttemptRecord& record) {
  if (record.grasp) {
    return record.outcome.success ? FailureReason::kNone : record.outcome.failure;
  }
  return AnyVisible(record) ? FailureReason::kNoGrasp : FailureReason::kNotVisible;
}

FailureReason FailureOfGrasp(const AttemptRecord& record, const ScoredHypothesis& chosen,
                             const InstanceMatcher& truth) {
  if (record.outcome.success) return FailureReason::kNone;
  const FailureReason physical = record.outcome.failure;
  if (physical == FailureReason::kPhysicsFailed) return physical;
  if (!chosen.record.correct) return MakerOf(chosen, truth);
  return physical == FailureReason::kWrongObject ? FailureReason::kDoublePick : physical;
}

// Returns kNoGrasp if a hypothesis is correct, else the reason why the first one is wrong.
FailureReason FailureOfPlan(const std::vector<const ScoredHypothesis*>& hypotheses,
                            const InstanceMatcher& truth) {
  const bool any_right = std::any_of(hypotheses.begin(), hypotheses.end(),
                                     [](const auto* h) { return h->record.correct; });
  return any_right ? FailureReason::kNoGrasp : MakerOf(*hypotheses.front(), truth);
}

// The reason if no hypothesis may be grasped.
FailureReason FailureWithoutHypothesis(const AttemptRecord& record) {
  if (record.target >= 0) {
    for (const InstanceRecord& instance : record.instances) {
      if (instance.instance == record.target && !instance.recalled) return instance.missed;
    }
    return FailureReason::kNoGrasp;
  }
  return AnyVisible(record) ? FailureReason::kNoProposal : FailureReason::kNotVisible;
}

}  // namespace

FailureReason AttributeFailure(const AttemptRecord& record,
                               const std::vector<ScoredHypothesis>& hypotheses,
                               double match_diameters, const InstanceMatcher& truth) {
  if (record.pose_free) return FailureWithoutPoses(record);
  if (record.grasp) return FailureOfGrasp(record, hypotheses[record.chosen], truth);
  std::vector<const ScoredHypothesis*> graspable;
  for (const ScoredHypothesis& h : hypotheses) {
    if (IsGraspable(h.record, record.target, match_diameters)) graspable.push_back(&h);
  }
  return graspable.empty() ? FailureWithoutHypothesis(record) : FailureOfPlan(graspable, truth);
}

std::vector<FailureReason> MissReasons(const AttemptScore& attempt, const InstanceMatcher& truth) {
  std::vector<FailureReason> missed;
  for (size_t i = 0; i < attempt.instances.size(); ++i) {
    const InstanceRecord& instance = attempt.instances[i];
    if (instance.recalled) {
      missed.push_back(FailureReason::kNone);
    } else if (instance.visible_fraction < kCountedVisibility) {
      missed.push_back(FailureReason::kNotVisible);
    } else {
      missed.push_back(MissReason(truth, static_cast<int>(i), attempt.hypotheses));
    }
  }
  return missed;
}

}  // namespace pickbed::eval
