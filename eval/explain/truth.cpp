#include "eval/explain/truth.h"

#include <algorithm>

#include "eval/cell/simulated_cell.h"

namespace pickbed::eval {
namespace {

constexpr int kJudgedVertices = 300;  // per mesh
constexpr float kOnSurface_m = 0.004;

std::shared_ptr<const std::vector<MetricModel>> JudgedModels(const ObjectSet& objects) {
  std::vector<MetricModel> models;
  for (const auto& object : objects) models.push_back(MakeMetricModel(*object, kJudgedVertices));
  return std::make_shared<const std::vector<MetricModel>>(std::move(models));
}

// Instance with the nearest surface to a point, within kOnSurface_m; -1 = none.
int InstanceUnder(const Eigen::Vector3f& p_C, const std::vector<TrueInstance>& instances,
                  const std::vector<ModelPoints>& models) {
  int under = -1;
  float min_m = kOnSurface_m;
  for (size_t i = 0; i < instances.size(); ++i) {
    const Eigen::Vector3f p_O = (instances[i].X_CO.inverse() * p_C.cast<double>()).cast<float>();
    const float distance_m = models[instances[i].object].distance.At(p_O);
    if (distance_m >= min_m) continue;
    min_m = distance_m;
    under = static_cast<int>(i);
  }
  return under;
}

void CountPoints(const PoseJudge& judge, const EstimateTrace& trace,
                 const std::vector<ModelPoints>& models, std::vector<InstanceDiagnosis>& outcomes) {
  for (const TracedPatch& patch : trace.patches) {
    const int position =
        InstanceUnder(trace.cloud.points_C[patch.pixel], judge.instances(), models);
    if (position >= 0) ++outcomes[position].points;
  }
}

void FollowIcp(const PoseJudge& judge, const EstimateTrace& trace,
               std::vector<InstanceDiagnosis>& outcomes) {
  const auto note = [&](const RawHypothesis& pose, double InstanceDiagnosis::*best) {
    const InstanceMatch error = judge(pose.object, pose.X_CO);
    if (error.position < 0) return;
    double& minimum = outcomes[error.position].*best;
    minimum = std::min(minimum, error.mssd_diameters);
  };
  for (const TracedRefinement& refinement : trace.refinements) {
    note(refinement.before, &InstanceDiagnosis::best_start);
    note(refinement.after, &InstanceDiagnosis::best_refined);
  }
}

// For each instance: whether one of the poses is correct for it.
std::vector<bool> Covered(const PoseJudge& judge, const std::vector<PoseHypothesis>& poses) {
  std::vector<bool> covered(judge.instances().size(), false);
  for (const PoseHypothesis& pose : poses) {
    const InstanceMatch error = judge(pose.object, pose.X_CO);
    if (error.correct) covered[error.position] = true;
  }
  return covered;
}

FailingStage FailingStageOf(const InstanceDiagnosis& instance_outcome, const TrueInstance& instance,
                            const EstimateTrace& trace, bool accepted, bool reported) {
  if (reported) return FailingStage::kFound;
  if (instance.visible_fraction < kCountedVisibility) return FailingStage::kHardlyVisible;
  if (accepted) return FailingStage::kRefiner;
  if (instance_outcome.best_score >= trace.min_score) {
    return CountUsedUp(trace, instance.object, instance_outcome.best_score)
               ? FailingStage::kCount
               : FailingStage::kPoseSelection;
  }
  if (instance_outcome.best_score >= 0) return FailingStage::kVerifier;
  if (instance_outcome.best_refined < kCorrectDiameters) return FailingStage::kMerging;
  if (instance_outcome.best_start < kReachDiameters) return FailingStage::kIcp;
  if (instance_outcome.votes_near > 0) return FailingStage::kSelection;
  return instance_outcome.points > 0 ? FailingStage::kVotes : FailingStage::kPoints;
}

}  // namespace

bool CountUsedUp(const EstimateTrace& trace, ObjectId object, double score) {
  if (trace.instances.empty()) return false;
  return std::ranges::count_if(trace.accepted, [&](const PoseHypothesis& pose) {
           return pose.object == object && pose.score >= score;
         }) >= trace.instances[object];
}

PoseJudge::PoseJudge(const ObjectSet& objects, std::vector<TrueInstance> instances)
    : models_(JudgedModels(objects)), matcher_(*models_, std::move(instances)) {}

std::vector<Verdict> JudgeSet(const PoseJudge& judge,
                              const std::vector<PoseHypothesis>& hypotheses) {
  std::vector<bool> taken(judge.instances().size(), false);
  std::vector<Verdict> verdicts;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    const InstanceMatch error = judge(hypothesis.object, hypothesis.X_CO);
    if (!error.correct) {
      verdicts.push_back(Verdict::kWrong);
      continue;
    }
    verdicts.push_back(taken[error.position] ? Verdict::kSecond : Verdict::kRight);
    taken[error.position] = true;
  }
  return verdicts;
}

FailingStageText TextOf(FailingStage stage) {
  switch (stage) {
    case FailingStage::kFound:
      return {"found", "a reported pose is right for it"};
    case FailingStage::kHardlyVisible:
      return {"barely visible", "less than 10 % visible: it need not be found"};
    case FailingStage::kPoints:
      return {"points", "no sampled point is on it: raise the number of points"};
    case FailingStage::kVotes:
      return {"votes", "patches on it, but none voted for a pose within ICP's reach: descriptors"};
    case FailingStage::kSelection:
      return {"selection", "votes within ICP's reach, but none was selected for refinement"};
    case FailingStage::kIcp:
      return {"ICP", "ICP refined a start within reach to a wrong pose"};
    case FailingStage::kMerging:
      return {"merging", "ICP reached the right pose, but it was merged into a wrong one"};
    case FailingStage::kVerifier:
      return {"verifier", "the right candidate scored too low"};
    case FailingStage::kPoseSelection:
      return {"pose selection",
              "the right candidate was suppressed by one that explains the same pixels"};
    case FailingStage::kCount:
      return {"count", "the given number of instances was reached with higher scores"};
    case FailingStage::kRefiner:
      return {"refiner", "the final refiner moved the right pose away"};
  }
  return {"?", ""};
}

std::vector<InstanceDiagnosis> DiagnoseInstances(const PoseJudge& judge, const EstimateTrace& trace,
                                                 const std::vector<InstanceMatch>& vote_errors,
                                                 const std::vector<ModelPoints>& models,
                                                 const std::vector<PoseHypothesis>& hypotheses) {
  std::vector<InstanceDiagnosis> outcomes(judge.instances().size());
  CountPoints(judge, trace, models, outcomes);
  for (const InstanceMatch& error : vote_errors) {
    if (error.position < 0) continue;
    outcomes[error.position].votes_near += error.mssd_diameters < kReachDiameters;
    outcomes[error.position].votes_right += error.correct;
  }
  FollowIcp(judge, trace, outcomes);
  for (const TracedCandidate& candidate : trace.candidates) {
    const InstanceMatch error = judge(candidate.hypothesis.object, candidate.hypothesis.X_CO);
    if (!error.correct) continue;
    double& best = outcomes[error.position].best_score;
    best = std::max(best, candidate.hypothesis.score);
  }
  const std::vector<bool> accepted = Covered(judge, trace.accepted);
  const std::vector<bool> reported = Covered(judge, hypotheses);
  for (size_t i = 0; i < outcomes.size(); ++i) {
    outcomes[i].failing_stage =
        FailingStageOf(outcomes[i], judge.instances()[i], trace, accepted[i], reported[i]);
  }
  return outcomes;
}

}  // namespace pickbed::eval
