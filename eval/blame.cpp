#include "eval/blame.h"

#include <algorithm>
#include <limits>

#include "eval/virtual_cell.h"

namespace pickbed {
namespace {

// Poses against the truth of one look.
class Judge {
 public:
  explicit Judge(const LookTruth& truth) : truth_(truth) {
    const Pose X_CW = truth.camera.X_WC.inverse();
    for (const MetricModel& model : truth.models) means_O_.push_back(MeanVertex(model));
    for (const PosedObject& posed : truth.scene.objects) X_CO_.push_back(X_CW * posed.X_WO);
  }

  bool IsRightFor(size_t instance, int object, const Pose& X_CO) const {
    if (truth_.scene.objects[instance].object != object) return false;
    const MetricModel& model = truth_.models[object];
    const double limit_m = kCorrectDiameters * model.diameter_m;
    // No vertex moves less than their mean: most pairs never need the maximum over all.
    const Eigen::Vector3d mean_C = X_CO * means_O_[object];
    const bool near =
        std::any_of(model.symmetries_O.begin(), model.symmetries_O.end(), [&](const Pose& S_O) {
          return (mean_C - X_CO_[instance] * (S_O * means_O_[object])).norm() < limit_m;
        });
    return near && Mssd(model, X_CO, X_CO_[instance]) < limit_m;
  }

  bool IsRight(int object, const Pose& X_CO) const {
    for (size_t i = 0; i < X_CO_.size(); ++i) {
      if (IsRightFor(i, object, X_CO)) return true;
    }
    return false;
  }

  // The instance of whatever kind whose mean vertex is nearest; -1 = the bin is empty.
  int Nearest(const PoseHypothesis& hypothesis) const {
    const Eigen::Vector3d mean_C = hypothesis.X_CO * means_O_[hypothesis.object];
    int nearest = -1;
    double least_m = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < X_CO_.size(); ++i) {
      const int object = truth_.scene.objects[i].object;
      const double distance_m = (X_CO_[i] * means_O_[object] - mean_C).norm();
      if (distance_m >= least_m) continue;
      least_m = distance_m;
      nearest = static_cast<int>(i);
    }
    return nearest;
  }

  // Who made a wrong hypothesis wrong.
  Loss MakerOf(const PoseHypothesis& wrong) const {
    const auto right = [&](const Pose& X_CO) { return IsRight(wrong.object, X_CO); };
    if (wrong.unrefined_X_CO && right(*wrong.unrefined_X_CO)) return Loss::kRefinementWorse;
    const auto& suppressed = wrong.suppressed_X_CO;
    if (std::any_of(suppressed.begin(), suppressed.end(), right)) return Loss::kSuppressed;
    const int nearest = Nearest(wrong);
    const bool own_kind = nearest >= 0 && truth_.scene.objects[nearest].object == wrong.object;
    return own_kind ? Loss::kPoseWrong : Loss::kWrongPart;
  }

 private:
  const LookTruth& truth_;
  std::vector<Eigen::Vector3d> means_O_;  // by object
  std::vector<Pose> X_CO_;                // by instance
};

Loss WhyMissedOne(const Judge& judge, const LookTruth& truth, size_t instance,
                  const std::vector<PoseHypothesis>& hypotheses, const std::vector<int>& nearest) {
  const auto right = [&](int object, const Pose& X_CO) {
    return judge.IsRightFor(instance, object, X_CO);
  };
  for (const PoseHypothesis& h : hypotheses) {
    if (h.unrefined_X_CO && right(h.object, *h.unrefined_X_CO)) return Loss::kRefinementWorse;
  }
  Loss missed = Loss::kNoProposal;
  for (size_t i = 0; i < hypotheses.size(); ++i) {
    const PoseHypothesis& h = hypotheses[i];
    for (const Pose& X_CO : h.suppressed_X_CO) {
      if (right(h.object, X_CO)) return Loss::kSuppressed;
    }
    if (nearest[i] != static_cast<int>(instance)) continue;
    const bool own_kind = h.object == truth.scene.objects[instance].object;
    if (own_kind) missed = Loss::kPoseWrong;
    if (!own_kind && missed == Loss::kNoProposal) missed = Loss::kWrongPart;
  }
  return missed;
}

}  // namespace

Loss LossOf(const PickRecord& record, const PoseHypothesis& chosen, const LookTruth& truth) {
  if (record.outcome.success) return Loss::kNone;
  const Loss physical = record.outcome.loss;
  if (physical == Loss::kPhysicsFailed) return physical;
  if (!record.hypotheses[record.chosen].correct) return Judge(truth).MakerOf(chosen);
  return physical == Loss::kWrongPart ? Loss::kTookTwo : physical;
}

Loss LossWithoutGrasp(const PickRecord& record, const std::vector<PoseHypothesis>& hypotheses,
                      const LookTruth& truth) {
  if (hypotheses.empty()) {
    const bool any_visible = std::any_of(record.instances.begin(), record.instances.end(),
                                         [](const InstanceRecord& instance) {
                                           return instance.visible_fraction >= kCountedVisibility;
                                         });
    return any_visible ? Loss::kNoProposal : Loss::kNotVisible;
  }
  const bool any_right = std::any_of(record.hypotheses.begin(), record.hypotheses.end(),
                                     [](const HypothesisScore& score) { return score.correct; });
  return any_right ? Loss::kNoGrasp : Judge(truth).MakerOf(hypotheses.front());
}

Loss LossWithoutGraspOnTarget(const PickRecord& record, const std::vector<int>& aims,
                              const std::vector<PoseHypothesis>& hypotheses,
                              const LookTruth& truth) {
  if (aims.empty()) {
    for (const InstanceRecord& instance : record.instances) {
      if (instance.instance == record.target && !instance.recalled) return instance.missed;
    }
    return Loss::kNoGrasp;
  }
  const bool any_right = std::any_of(aims.begin(), aims.end(),
                                     [&](int aim) { return record.hypotheses[aim].correct; });
  return any_right ? Loss::kNoGrasp : Judge(truth).MakerOf(hypotheses[aims.front()]);
}

std::vector<Loss> WhyMissed(const LookScore& look, const std::vector<PoseHypothesis>& hypotheses,
                            const LookTruth& truth) {
  const Judge judge(truth);
  std::vector<int> nearest;
  for (const PoseHypothesis& hypothesis : hypotheses) nearest.push_back(judge.Nearest(hypothesis));
  std::vector<Loss> missed;
  for (size_t i = 0; i < look.instances.size(); ++i) {
    const InstanceRecord& instance = look.instances[i];
    if (instance.recalled) {
      missed.push_back(Loss::kNone);
    } else if (instance.visible_fraction < kCountedVisibility) {
      missed.push_back(Loss::kNotVisible);
    } else {
      missed.push_back(WhyMissedOne(judge, truth, i, hypotheses, nearest));
    }
  }
  return missed;
}

}  // namespace pickbed
