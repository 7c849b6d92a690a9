#include "eval/trial_observer.h"

namespace pickbed {
namespace {

uint64_t HashOfStage(TrialStage stage, const LookState& look) {
  switch (stage) {
    case TrialStage::kScene:
      return HashOf(look.scene);
    case TrialStage::kImage:
      return HashOf(*look.view);
    case TrialStage::kHypotheses:
      return HashOfHypotheses(look.record);
    case TrialStage::kGrasp:
      return HashOfGrasp(look.record);
    case TrialStage::kOutcome:
      return HashOfOutcome(look.record);
  }
  return 0;
}

}  // namespace

void ReachStage(TrialStage stage, const LookState& look, PickRecord& record,
                TrialObserver* observer) {
  record.hashes[stage] = HashOfStage(stage, look);
  if (observer != nullptr) observer->OnStage(stage, look);
}

}  // namespace pickbed
