#include "eval/trial/observer.h"

namespace pickbed::eval {
namespace {

uint64_t HashOfStage(TrialStage stage, const AttemptState& attempt) {
  switch (stage) {
    case TrialStage::kScene:
      return HashOf(attempt.scene);
    case TrialStage::kImage:
      return HashOf(*attempt.view);
    case TrialStage::kHypotheses:
      return HashOfHypotheses(attempt.record);
    case TrialStage::kGrasp:
      return HashOfGrasp(attempt.record);
    case TrialStage::kOutcome:
      return HashOfOutcome(attempt.record);
  }
  return 0;
}

}  // namespace

void ReachStage(TrialStage stage, const AttemptState& attempt, AttemptRecord& record,
                TrialObserver* observer) {
  record.hashes[stage] = HashOfStage(stage, attempt);
  if (observer != nullptr) observer->OnStage(stage, attempt);
}

}  // namespace pickbed::eval
