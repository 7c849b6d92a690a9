#include "eval/blame.h"

#include <algorithm>

#include "eval/matching.h"

namespace pickbed {

Loss LossOf(const PickRecord& record, const PoseHypothesis& chosen, const LookTruth& truth) {
  if (record.outcome.success) return Loss::kNone;
  // Neither is a matter of belief: physics broke, or the hand held a part of another kind.
  const Loss physical = record.outcome.loss;
  if (physical == Loss::kPhysicsFailed || physical == Loss::kWrongPart) return physical;
  if (record.hypotheses[record.chosen].correct) return record.outcome.loss;
  const Pose X_CW = truth.camera.X_WC.inverse();
  const auto& posed = truth.scene.objects;
  const MetricModel& model = truth.models[chosen.object];
  const auto right = [&](const Pose& X_CO) {
    return std::any_of(posed.begin(), posed.end(), [&](const PosedObject& object) {
      return object.object == chosen.object &&
             Mssd(model, X_CO, X_CW * object.X_WO) < kCorrectDiameters * model.diameter_m;
    });
  };
  if (chosen.unrefined_X_CO && right(*chosen.unrefined_X_CO)) return Loss::kRefinementWorse;
  if (std::any_of(chosen.suppressed_X_CO.begin(), chosen.suppressed_X_CO.end(), right)) {
    return Loss::kSuppressed;
  }
  const auto distance_m = [&](const PosedObject& object) {
    return ((X_CW * object.X_WO).translation() - chosen.X_CO.translation()).norm();
  };
  const auto nearest = std::min_element(
      posed.begin(), posed.end(),
      [&](const PosedObject& a, const PosedObject& b) { return distance_m(a) < distance_m(b); });
  return nearest->object == chosen.object ? Loss::kPoseWrong : Loss::kWrongPart;
}

}  // namespace pickbed
