#include "eval/trial/failure_attribution.h"

#include <algorithm>
#include <limits>

#include "eval/trial/grasp_choice.h"
#include "eval/trial/simulated_cell.h"

namespace pickbed::eval {
namespace {

// Compares poses with the ground truth of one attempt.
class Judge {
 public:
  explicit Judge(const GroundTruth& truth) : truth_(truth) {
    const Pose X_CW = truth.camera.X_CW();
    for (const MetricModel& model : truth.models) means_O_.push_back(MeanVertex(model));
    for (const PosedObject& posed : truth.scene.objects) X_CO_.push_back(X_CW * posed.X_WO);
  }

  bool IsRightFor(size_t position, ObjectId object, const Pose& X_CO) const {
    if (truth_.scene.objects[position].object != object) return false;
    const MetricModel& model = truth_.models[object];
    const double limit_m = kCorrectDiameters * model.diameter_m;
    // The largest vertex displacement is at least the displacement of the mean vertex. This test
    // saves the costly maximum over all vertices for most pairs.
    const Eigen::Vector3d mean_C = X_CO * means_O_[object];
    const bool near =
        std::any_of(model.symmetries_O.begin(), model.symmetries_O.end(), [&](const Pose& S_O) {
          return (mean_C - X_CO_[position] * (S_O * means_O_[object])).norm() < limit_m;
        });
    return near && Mssd(model, X_CO, X_CO_[position]) < limit_m;
  }

  bool IsRight(ObjectId object, const Pose& X_CO) const {
    for (size_t i = 0; i < X_CO_.size(); ++i) {
      if (IsRightFor(i, object, X_CO)) return true;
    }
    return false;
  }

  // Returns the instance of any object whose mean vertex is nearest, -1 if the bin is empty.
  int Nearest(const PoseHypothesis& hypothesis) const {
    const Eigen::Vector3d mean_C = hypothesis.X_CO * means_O_[hypothesis.object];
    int nearest = -1;
    double least_m = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < X_CO_.size(); ++i) {
      const ObjectId object = truth_.scene.objects[i].object;
      const double distance_m = (X_CO_[i] * means_O_[object] - mean_C).norm();
      if (distance_m >= least_m) continue;
      least_m = distance_m;
      nearest = static_cast<int>(i);
    }
    return nearest;
  }

  // Returns the reason why a hypothesis is wrong: the last stage that had a correct pose for it.
  FailureReason MakerOf(const PoseHypothesis& wrong) const {
    const auto right = [&](const Pose& X_CO) { return IsRight(wrong.object, X_CO); };
    if (wrong.unrefined_X_CO && right(*wrong.unrefined_X_CO))
      return FailureReason::kRefinementWorse;
    const auto& suppressed = wrong.suppressed_X_CO;
    if (std::any_of(suppressed.begin(), suppressed.end(), right)) return FailureReason::kSuppressed;
    const int nearest = Nearest(wrong);
    const bool own_kind = nearest >= 0 && truth_.scene.objects[nearest].object == wrong.object;
    return own_kind ? FailureReason::kPoseWrong : FailureReason::kWrongObject;
  }

 private:
  const GroundTruth& truth_;
  std::vector<Eigen::Vector3d> means_O_;  // by object
  std::vector<Pose> X_CO_;                // by instance
};

FailureReason MissReason(const Judge& judge, const GroundTruth& truth, size_t position,
                         const std::vector<PoseHypothesis>& hypotheses,
                         const std::vector<int>& nearest) {
  const auto right = [&](ObjectId object, const Pose& X_CO) {
    return judge.IsRightFor(position, object, X_CO);
  };
  for (const PoseHypothesis& h : hypotheses) {
    if (h.unrefined_X_CO && right(h.object, *h.unrefined_X_CO))
      return FailureReason::kRefinementWorse;
  }
  FailureReason missed = FailureReason::kNoProposal;
  for (size_t i = 0; i < hypotheses.size(); ++i) {
    const PoseHypothesis& h = hypotheses[i];
    for (const Pose& X_CO : h.suppressed_X_CO) {
      if (right(h.object, X_CO)) return FailureReason::kSuppressed;
    }
    if (nearest[i] != static_cast<int>(position)) continue;
    const bool own_kind = h.object == truth.scene.objects[position].object;
    if (own_kind) missed = FailureReason::kPoseWrong;
    if (!own_kind && missed == FailureReason::kNoProposal) missed = FailureReason::kWrongObject;
  }
  return missed;
}

FailureReason FailureOfGrasp(const AttemptRecord& record, const PoseHypothesis& chosen,
                             const GroundTruth& truth) {
  if (record.outcome.success) return FailureReason::kNone;
  const FailureReason physical = record.outcome.failure;
  if (physical == FailureReason::kPhysicsFailed) return physical;
  if (!record.hypotheses[record.chosen].correct) return Judge(truth).MakerOf(chosen);
  return physical == FailureReason::kWrongObject ? FailureReason::kDoublePick : physical;
}

FailureReason FailureWithoutGrasp(const AttemptRecord& record,
                                  const std::vector<PoseHypothesis>& hypotheses,
                                  const GroundTruth& truth) {
  if (hypotheses.empty()) {
    const bool any_visible = std::any_of(record.instances.begin(), record.instances.end(),
                                         [](const InstanceRecord& instance) {
                                           return instance.visible_fraction >= kCountedVisibility;
                                         });
    return any_visible ? FailureReason::kNoProposal : FailureReason::kNotVisible;
  }
  const bool any_right = std::any_of(record.hypotheses.begin(), record.hypotheses.end(),
                                     [](const HypothesisRecord& score) { return score.correct; });
  return any_right ? FailureReason::kNoGrasp : Judge(truth).MakerOf(hypotheses.front());
}

FailureReason FailureWithoutGraspOnTarget(const AttemptRecord& record,
                                          const std::vector<int>& target_poses,
                                          const std::vector<PoseHypothesis>& hypotheses,
                                          const GroundTruth& truth) {
  if (target_poses.empty()) {
    for (const InstanceRecord& instance : record.instances) {
      if (instance.instance == record.target && !instance.recalled) return instance.missed;
    }
    return FailureReason::kNoGrasp;
  }
  const bool any_right = std::any_of(target_poses.begin(), target_poses.end(),
                                     [&](int pose) { return record.hypotheses[pose].correct; });
  return any_right ? FailureReason::kNoGrasp
                   : Judge(truth).MakerOf(hypotheses[target_poses.front()]);
}

}  // namespace

FailureReason AttributeFailure(const AttemptRecord& record,
                               const std::vector<PoseHypothesis>& hypotheses,
                               double match_diameters, const GroundTruth& truth) {
  if (record.grasp) return FailureOfGrasp(record, hypotheses[record.chosen], truth);
  if (record.target < 0) return FailureWithoutGrasp(record, hypotheses, truth);
  return FailureWithoutGraspOnTarget(record, GraspableHypotheses(record, match_diameters),
                                     hypotheses, truth);
}

std::vector<FailureReason> MissReasons(const AttemptScore& attempt,
                                       const std::vector<PoseHypothesis>& hypotheses,
                                       const GroundTruth& truth) {
  const Judge judge(truth);
  std::vector<int> nearest;
  for (const PoseHypothesis& hypothesis : hypotheses) nearest.push_back(judge.Nearest(hypothesis));
  std::vector<FailureReason> missed;
  for (size_t i = 0; i < attempt.instances.size(); ++i) {
    const InstanceRecord& instance = attempt.instances[i];
    if (instance.recalled) {
      missed.push_back(FailureReason::kNone);
    } else if (instance.visible_fraction < kCountedVisibility) {
      missed.push_back(FailureReason::kNotVisible);
    } else {
      missed.push_back(MissReason(judge, truth, i, hypotheses, nearest));
    }
  }
  return missed;
}

}  // namespace pickbed::eval
