#include "eval/explain/truth.h"

#include <algorithm>

#include "eval/trial/simulated_cell.h"

namespace pickbed::eval {
namespace {

constexpr int kJudgedVertices = 300;  // per mesh
constexpr float kOnSurface_m = 0.004;

// Instance with the nearest surface to a point, within kOnSurface_m; -1 = none.
int PartUnder(const Eigen::Vector3f& p_C, const std::vector<TruePart>& parts,
              const std::vector<ModelPoints>& models) {
  int under = -1;
  float least_m = kOnSurface_m;
  for (size_t i = 0; i < parts.size(); ++i) {
    const Eigen::Vector3f p_O = (parts[i].X_CO.inverse() * p_C.cast<double>()).cast<float>();
    const float distance_m = models[parts[i].object].distance.At(p_O);
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    under = static_cast<int>(i);
  }
  return under;
}

void CountPoints(const PoseJudge& judge, const EstimateTrace& trace,
                 const std::vector<ModelPoints>& models, std::vector<InstanceDiagnosis>& outcomes) {
  for (const TracedPatch& patch : trace.patches) {
    const int position = PartUnder(trace.cloud.points_C[patch.pixel], judge.parts(), models);
    if (position >= 0) ++outcomes[position].points;
  }
}

void FollowIcp(const PoseJudge& judge, const EstimateTrace& trace,
               std::vector<InstanceDiagnosis>& outcomes) {
  const auto note = [&](const RawHypothesis& pose, double InstanceDiagnosis::*best) {
    const PoseVerdict error = judge(pose.object, pose.X_CO);
    if (error.position < 0) return;
    double& least = outcomes[error.position].*best;
    least = std::min(least, error.diameters);
  };
  for (const TracedRefinement& refinement : trace.refinements) {
    note(refinement.before, &InstanceDiagnosis::best_start);
    note(refinement.after, &InstanceDiagnosis::best_refined);
  }
}

// For each instance: whether one of the poses is correct for it.
std::vector<bool> Covered(const PoseJudge& judge, const std::vector<PoseHypothesis>& poses) {
  std::vector<bool> covered(judge.parts().size(), false);
  for (const PoseHypothesis& pose : poses) {
    const PoseVerdict error = judge(pose.object, pose.X_CO);
    if (error.right()) covered[error.position] = true;
  }
  return covered;
}

LostAt LostStageOf(const InstanceDiagnosis& instance_outcome, const TruePart& part,
                   const EstimateTrace& trace, bool accepted, bool reported) {
  if (reported) return LostAt::kFound;
  if (part.visible_fraction < kCountedVisibility) return LostAt::kHardlyVisible;
  if (accepted) return LostAt::kRefiner;
  if (instance_outcome.best_score >= trace.min_score) {
    return CountUsedUp(trace, part.object, instance_outcome.best_score) ? LostAt::kCount
                                                                        : LostAt::kPoseSelection;
  }
  if (instance_outcome.best_score >= 0) return LostAt::kVerifier;
  if (instance_outcome.best_refined < kCorrectDiameters) return LostAt::kMerging;
  if (instance_outcome.best_start < kReachDiameters) return LostAt::kIcp;
  if (instance_outcome.votes_near > 0) return LostAt::kSelection;
  return instance_outcome.points > 0 ? LostAt::kVotes : LostAt::kPoints;
}

}  // namespace

bool CountUsedUp(const EstimateTrace& trace, ObjectId object, double score) {
  if (trace.instances.empty()) return false;
  return std::ranges::count_if(trace.accepted, [&](const PoseHypothesis& pose) {
           return pose.object == object && pose.score >= score;
         }) >= trace.instances[object];
}

PoseJudge::PoseJudge(const ObjectSet& objects, std::vector<TruePart> parts)
    : parts_(std::move(parts)) {
  for (const auto& object : objects) {
    models_.push_back(MakeMetricModel(*object, kJudgedVertices));
    means_O_.push_back(MeanVertex(models_.back()));
  }
}

PoseVerdict PoseJudge::operator()(ObjectId object, const Pose& X_CO) const {
  const MetricModel& model = models_.at(object);
  const Eigen::Vector3d mean_C = X_CO * means_O_[object];
  // The displacement of the mean vertex is a lower bound of MSSD. It allows skipping instances that
  // are too far away.
  std::vector<std::pair<double, int>> bounds;  // diameters, position
  for (size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].object != object) continue;
    double bound_m = std::numeric_limits<double>::infinity();
    for (const Pose& S_O : model.symmetries_O) {
      bound_m = std::min(bound_m, (mean_C - parts_[i].X_CO * (S_O * means_O_[object])).norm());
    }
    bounds.emplace_back(bound_m / model.diameter_m, static_cast<int>(i));
  }
  std::ranges::sort(bounds);
  PoseVerdict best;
  for (const auto& [bound, position] : bounds) {
    if (bound >= best.diameters) break;
    const double error = Mssd(model, X_CO, parts_[position].X_CO) / model.diameter_m;
    if (error < best.diameters) best = {position, error};
  }
  return best;
}

std::vector<Verdict> JudgeSet(const PoseJudge& judge,
                              const std::vector<PoseHypothesis>& hypotheses) {
  std::vector<bool> taken(judge.parts().size(), false);
  std::vector<Verdict> verdicts;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    const PoseVerdict error = judge(hypothesis.object, hypothesis.X_CO);
    if (!error.right()) {
      verdicts.push_back(Verdict::kWrong);
      continue;
    }
    verdicts.push_back(taken[error.position] ? Verdict::kSecond : Verdict::kRight);
    taken[error.position] = true;
  }
  return verdicts;
}

LostAtText TextOf(LostAt lost) {
  switch (lost) {
    case LostAt::kFound:
      return {"found", "a reported pose is right for it"};
    case LostAt::kHardlyVisible:
      return {"barely visible", "less than 10 % visible: it need not be found"};
    case LostAt::kPoints:
      return {"points", "no sampled point is on it: raise the number of points"};
    case LostAt::kVotes:
      return {"votes", "patches on it, but none voted for a pose within ICP's reach: descriptors"};
    case LostAt::kSelection:
      return {"selection", "votes within ICP's reach, but none was selected for refinement"};
    case LostAt::kIcp:
      return {"ICP", "ICP refined a start within reach to a wrong pose"};
    case LostAt::kMerging:
      return {"merging", "ICP reached the right pose, but it was merged into a wrong one"};
    case LostAt::kVerifier:
      return {"verifier", "the right candidate scored too low"};
    case LostAt::kPoseSelection:
      return {"pose selection",
              "the right candidate was suppressed by one that explains the same pixels"};
    case LostAt::kCount:
      return {"count", "the given number of instances was reached with higher scores"};
    case LostAt::kRefiner:
      return {"refiner", "the final refiner moved the right pose away"};
  }
  return {"?", ""};
}

std::vector<InstanceDiagnosis> DiagnoseInstances(const PoseJudge& judge, const EstimateTrace& trace,
                                                 const std::vector<PoseVerdict>& vote_errors,
                                                 const std::vector<ModelPoints>& models,
                                                 const std::vector<PoseHypothesis>& hypotheses) {
  std::vector<InstanceDiagnosis> outcomes(judge.parts().size());
  CountPoints(judge, trace, models, outcomes);
  for (const PoseVerdict& error : vote_errors) {
    if (error.position < 0) continue;
    outcomes[error.position].votes_near += error.diameters < kReachDiameters;
    outcomes[error.position].votes_right += error.right();
  }
  FollowIcp(judge, trace, outcomes);
  for (const TracedCandidate& candidate : trace.candidates) {
    const PoseVerdict error = judge(candidate.hypothesis.object, candidate.hypothesis.X_CO);
    if (!error.right()) continue;
    double& best = outcomes[error.position].best_score;
    best = std::max(best, candidate.hypothesis.score);
  }
  const std::vector<bool> accepted = Covered(judge, trace.accepted);
  const std::vector<bool> reported = Covered(judge, hypotheses);
  for (size_t i = 0; i < outcomes.size(); ++i) {
    outcomes[i].lost = LostStageOf(outcomes[i], judge.parts()[i], trace, accepted[i], reported[i]);
  }
  return outcomes;
}

}  // namespace pickbed::eval
