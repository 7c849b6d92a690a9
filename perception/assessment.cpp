#include "perception/assessment.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "perception/look_alikes.h"

namespace pickbed {
namespace {

// How much worse the best rival fits: another pose of the part at the same place. Bounded, and the
// bound where there is none.
void FillMargins(const PoseDistance& distance, const Eigen::Vector3d& middle_O,
                 std::vector<Candidate>& candidates) {
  constexpr double kSamePlaceDiameters = 0.3, kOtherPoseDiameters = 0.12;
  constexpr float kMostMargin = 0.5f;
  const double near_m = kSamePlaceDiameters * distance.diameter_m();
  std::vector<Eigen::Vector3d> middles_C;
  for (const Candidate& c : candidates) middles_C.push_back(c.hypothesis.X_CO * middle_O);
  for (size_t i = 0; i < candidates.size(); ++i) {
    const float misfit = candidates[i].features[kMisfitFeature];
    float margin = kMostMargin;
    for (size_t j = 0; j < candidates.size(); ++j) {
      const float rival = candidates[j].features[kMisfitFeature] - misfit;
      if (rival >= margin || j == i) continue;
      if ((middles_C[i] - middles_C[j]).norm() > near_m) continue;
      const Pose& X_CO = candidates[j].hypothesis.X_CO;
      if (distance(candidates[i].hypothesis.X_CO, X_CO) > kOtherPoseDiameters) margin = rival;
    }
    candidates[i].features[kMarginFeature] = std::max(margin, -kMostMargin);
  }
}

}  // namespace

void AssessmentOptions::Visit(SettingsVisitor& v) {
  v.Integer("candidates", candidates, {1, 100000}, "poses refined, all parts together");
  v.Integer("min_candidates", min_candidates, {1, 100000}, "poses refined for each part at least");
  v.Real("quick_tau_m", quick_tau_m, {1e-4, 0.1}, "band of the quick score, m");
  v.Real("density_weight", density_weight, {0, 10}, "of the votes' density in their rank");
  v.Real("density_diameters", density_diameters, {1e-3, 1}, "votes within it count");
  v.Real("cluster_diameters", cluster_diameters, {0, 1}, "raw poses within it are one");
  v.Real("gate_diameters", gate_diameters, {1e-3, 1}, "first gate of ICP, diameters");
  v.Real("gate_min_m", gate_min_m, {1e-4, 1}, "least gate, m");
  v.Real("gate_max_m", gate_max_m, {1e-4, 1}, "largest gate, m");
  v.Bool("two_gates", two_gates, "also try half the gate and keep the better");
  v.Integer("turned", turned, {0, 100000}, "best poses of a part whose look-alikes are tried");
  v.Real("merge_diameters", merge_diameters, {0, 1}, "refined poses within it are one");
}

CandidateAssessor::CandidateAssessor(const ObjectSet& objects, const AssessmentOptions& options)
    : objects_(objects), options_(options) {
  for (const auto& object : objects_) {
    models_.push_back(MakeModelPoints(*object));
    distances_.emplace_back(*object);
    embeddings_.emplace_back(*object);
    look_alikes_.push_back(LookAlikes(*object, models_.back(), distances_.back()));
  }
}

std::vector<RawHypothesis> CandidateAssessor::QuickScored(
    const OrganizedCloud& cloud, int part, const std::vector<PoseVote>& votes) const {
  std::vector<RawHypothesis> scored;
  for (const PoseVote& vote : votes) {
    const double score = QuickScore(cloud, models_[part], vote.X_CO, options_.quick_tau_m);
    scored.push_back({part, vote.X_CO, static_cast<float>(score)});
  }
  return scored;
}

VoteDensity CandidateAssessor::Density(int part, const std::vector<PoseVote>& votes) const {
  const ObjectModel& model = *objects_[part];
  return VoteDensity(embeddings_[part], model.mass.com_O, model.diameter_m,
                     options_.density_diameters, votes);
}

int CandidateAssessor::Kept() const {
  return std::max(options_.min_candidates, options_.candidates / static_cast<int>(objects_.size()));
}

// `scored` are the poses of `votes`. A patch does not agree with itself.
std::vector<RawHypothesis> CandidateAssessor::Selected(std::vector<RawHypothesis> scored,
                                                       const VoteDensity& density,
                                                       const std::vector<PoseVote>& votes) const {
  for (size_t i = 0; i < votes.size(); ++i) {
    const double agreeing = density.Around(votes[i].X_CO, votes[i].patch);
    scored[i].quick_score += static_cast<float>(options_.density_weight * std::log1p(agreeing));
  }
  return ClusterVotes(std::move(scored), distances_, options_.cluster_diameters, Kept());
}

// Quick score becomes the score of the refined pose in the fine gate.
RawHypothesis CandidateAssessor::Refined(const OrganizedCloud& cloud,
                                         const RawHypothesis& start) const {
  const ModelPoints& model = models_[start.object];
  ProjectiveIcpOptions icp = options_.icp;
  const double gate = std::clamp(options_.gate_diameters * model.diameter_m, options_.gate_min_m,
                                 options_.gate_max_m);
  RawHypothesis best = start;
  for (int run = 0; run < (options_.two_gates ? 2 : 1); ++run) {
    icp.gate_m = std::max(run == 0 ? gate : 0.5 * gate, icp.gate_end_m);
    const Pose X_CO = ProjectiveIcp(cloud, model, start.X_CO, icp).X_CO;
    const float score = static_cast<float>(QuickScore(cloud, model, X_CO, icp.gate_end_m));
    if (run > 0 && score <= best.quick_score) continue;
    best.X_CO = X_CO;
    best.quick_score = score;
  }
  return best;
}

// `poses` best first.
void CandidateAssessor::AddLookAlikes(const OrganizedCloud& cloud,
                                      std::vector<RawHypothesis>& poses) const {
  const size_t count = std::min<size_t>(poses.size(), options_.turned);
  for (size_t i = 0; i < count; ++i) {
    for (const Pose& S_O : look_alikes_[poses[i].object]) {
      RawHypothesis turned = poses[i];
      turned.X_CO = turned.X_CO * S_O;
      poses.push_back(Refined(cloud, turned));
    }
  }
}

std::vector<Candidate> CandidateAssessor::Assess(const OrganizedCloud& cloud, int part,
                                                 const std::vector<PoseVote>& votes, int patches,
                                                 StageSeconds& seconds) const {
  std::vector<RawHypothesis> poses;
  {
    const StageTimer timer(seconds, "quick");
    poses = QuickScored(cloud, part, votes);
  }
  std::optional<VoteDensity> density;
  {
    const StageTimer timer(seconds, "select");
    density.emplace(Density(part, votes));
    poses = Selected(std::move(poses), *density, votes);
  }
  {
    const StageTimer timer(seconds, "icp");
    for (RawHypothesis& pose : poses) pose = Refined(cloud, pose);
    poses = ClusterVotes(std::move(poses), distances_, options_.merge_diameters, Kept());
    AddLookAlikes(cloud, poses);
  }
  const StageTimer timer(seconds, "verify");
  // Votes that agree are more where more patches vote; the verifier sees them as of this many.
  constexpr double kUsualPatches = 600;
  const double per_patch = kUsualPatches / static_cast<double>(patches);
  std::vector<Candidate> candidates;
  for (const RawHypothesis& pose : poses) {
    Candidate& candidate = candidates.emplace_back();
    candidate.hypothesis = {part, pose.X_CO, pose.quick_score, {}};
    candidate.features =
        ComputeVerifyFeatures(cloud, models_[part], pose.X_CO,
                              per_patch * density->Around(pose.X_CO), candidate.hypothesis.fit);
  }
  FillMargins(distances_[part], models_[part].center_O.cast<double>(), candidates);
  return candidates;
}

}  // namespace pickbed
