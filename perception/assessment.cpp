#include "perception/assessment.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "perception/look_alikes.h"
#include "scenes/parallel.h"

namespace pickbed {
namespace {

// The highest first; among equals the order stays.
void KeepBest(size_t most, std::vector<std::pair<double, Pose>>& scored) {
  std::stable_sort(scored.begin(), scored.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  if (scored.size() > most) scored.resize(most);
}

}  // namespace

void AssessmentOptions::Visit(SettingsVisitor& v) {
  v.Integer("candidates", candidates, {1, 100000}, "poses refined, all parts together");
  v.Integer("min_candidates", min_candidates, {1, 100000}, "poses refined for each part at least");
  v.Real("quick_tau_m", quick_tau_m, {1e-4, 0.1}, "band of the quick score, m");
  v.Real("density_weight", density_weight, {0, 10}, "of the votes' density in their rank");
  v.Real("density_diameters", density_diameters, {1e-3, 1}, "votes within it count");
  v.Real("cluster_diameters", cluster_diameters, {1e-4, 1}, "raw poses within it are one");
  v.Real("gate_diameters", gate_diameters, {1e-3, 1}, "first gate of ICP, diameters");
  v.Real("gate_min_m", gate_min_m, {1e-4, 1}, "least gate, m");
  v.Real("gate_max_m", gate_max_m, {1e-4, 1}, "largest gate, m");
  v.Bool("two_gates", two_gates, "also try half the gate and keep the better");
  v.Integer("turned", turned, {0, 100000},
            "best poses, of all parts together, whose look-alikes are tried");
  v.Integer("look_alikes", look_alikes, {1, 1000}, "look-alikes of a pose that are refined");
  v.Integer("drawn", drawn, {1, 1000}, "look-alikes of a pose whose evidence is measured");
  v.Real("least_quick_score", least_quick_score, {-1, 1}, "of a refined pose");
  v.Integer("fine_points", fine_points, {6, 512}, "points of the last steps of ICP");
  v.Integer("fine_steps", fine_steps, {0, 100}, "last steps of ICP, by more points");
  v.Integer("evidence_pixels", evidence_pixels, {1, 1000000}, "of a candidate looked at, about");
  v.Real("merge_diameters", merge_diameters, {1e-4, 1}, "refined poses within it are one");
}

CandidateAssessor::CandidateAssessor(const ObjectSet& objects, const AssessmentOptions& options,
                                     int threads)
    : objects_(objects), options_(options), threads_(threads) {
  for (const auto& object : objects_) {
    models_.push_back(MakeModelPoints(*object));
    evidence_.emplace_back(*object);
    distances_.emplace_back(*object);
    embeddings_.emplace_back(*object);
    look_alikes_.push_back(LookAlikes(*object, models_.back(), distances_.back()));
  }
}

std::vector<RawHypothesis> CandidateAssessor::QuickScored(
    const OrganizedCloud& cloud, int part, const std::vector<PoseVote>& votes) const {
  std::vector<RawHypothesis> scored(votes.size());
  ForRanges(static_cast<int>(votes.size()), threads_, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Pose& X_CO = votes[i].X_CO;
      const double score = QuickScore(cloud, models_[part], X_CO, options_.quick_tau_m);
      scored[i] = {part, X_CO, static_cast<float>(score)};
    }
  });
  return scored;
}

VoteDensity CandidateAssessor::Density(int part, const std::vector<PoseVote>& votes) const {
  const ObjectModel& model = *objects_[part];
  return VoteDensity(embeddings_[part], model.mass.com_O, model.diameter_m,
                     options_.density_diameters, votes);
}

int CandidateAssessor::Kept(double share) const {
  const int all =
      std::max(options_.min_candidates, options_.candidates / static_cast<int>(objects_.size()));
  return std::max(1, static_cast<int>(share * all));
}

// Parts that share a bin share the places at which look-alikes are tried as they share candidates.
int CandidateAssessor::Turned() const {
  const double of_all = static_cast<double>(Kept(1)) / options_.candidates;
  return static_cast<int>(std::ceil(options_.turned * std::min(1.0, of_all)));
}

// `scored` are the poses of `votes`. A patch does not agree with itself.
std::vector<RawHypothesis> CandidateAssessor::Selected(std::vector<RawHypothesis> scored,
                                                       const VoteDensity& density,
                                                       const std::vector<PoseVote>& votes,
                                                       int kept) const {
  ForRanges(static_cast<int>(votes.size()), threads_, [&](int begin, int end) {
    VoteDensity::Scratch scratch;
    for (int i = begin; i < end; ++i) {
      const double agreeing = density.Around(votes[i].X_CO, votes[i].patch, scratch);
      scored[i].quick_score += static_cast<float>(options_.density_weight * std::log1p(agreeing));
    }
  });
  return ClusterVotes(std::move(scored), distances_, options_.cluster_diameters, kept);
}

// Quick score becomes the score of the pose in the fine gate; where ICP made it worse, the start
// stands.
RawHypothesis CandidateAssessor::Refined(const OrganizedCloud& cloud,
                                         const RawHypothesis& start) const {
  const ModelPoints& model = models_[start.object];
  ProjectiveIcpOptions icp = options_.icp;
  const double gate = std::clamp(options_.gate_diameters * model.diameter_m, options_.gate_min_m,
                                 options_.gate_max_m);
  RawHypothesis best = start;
  best.quick_score = static_cast<float>(QuickScore(cloud, model, start.X_CO, icp.gate_end_m));
  for (int run = 0; run < (options_.two_gates ? 2 : 1); ++run) {
    icp.gate_m = std::max(run == 0 ? gate : 0.5 * gate, icp.gate_end_m);
    const Pose X_CO = ProjectiveIcp(cloud, model, start.X_CO, icp).X_CO;
    const float score = static_cast<float>(QuickScore(cloud, model, X_CO, icp.gate_end_m));
    if (score < best.quick_score || (run > 0 && score == best.quick_score)) continue;
    best.X_CO = X_CO;
    best.quick_score = score;
  }
  if (best.quick_score >= options_.least_quick_score) RefineFinely(cloud, best);
  return best;
}

// So few points as the first steps take leave a look-alike ahead of the true pose now and then.
void CandidateAssessor::RefineFinely(const OrganizedCloud& cloud, RawHypothesis& pose) const {
  constexpr float kMostLost = 0.05f;  // of the quick score, which counts whole points
  const ModelPoints& model = models_[pose.object];
  ProjectiveIcpOptions icp = options_.icp;
  icp.coarse_iterations = 0;
  icp.fine_iterations = options_.fine_steps;
  icp.max_points = options_.fine_points;
  const Pose X_CO = ProjectiveIcp(cloud, model, pose.X_CO, icp).X_CO;
  const float score = static_cast<float>(QuickScore(cloud, model, X_CO, icp.gate_end_m));
  if (score < pose.quick_score - kMostLost) return;
  pose.X_CO = X_CO;
  pose.quick_score = score;
}

std::vector<RawHypothesis> CandidateAssessor::AllRefined(const OrganizedCloud& cloud,
                                                         const std::vector<RawHypothesis>& starts,
                                                         bool look_alikes,
                                                         EstimateTrace* trace) const {
  std::vector<RawHypothesis> refined(starts.size());
  ForRanges(static_cast<int>(starts.size()), threads_, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) refined[i] = Refined(cloud, starts[i]);
  });
  for (size_t i = 0; trace && i < starts.size(); ++i) {
    trace->refinements.push_back({starts[i], refined[i], look_alikes});
  }
  return refined;
}

// Equal ones are one, and those without hope are none.
std::vector<RawHypothesis> CandidateAssessor::Merged(std::vector<RawHypothesis> poses,
                                                     size_t most) const {
  std::erase_if(poses, [&](const RawHypothesis& pose) {
    return pose.quick_score < options_.least_quick_score;
  });
  return ClusterVotes(std::move(poses), distances_, options_.merge_diameters,
                      static_cast<int>(most));
}

// Those for which there is most evidence, best first. The quick score, a tenth of the work, tells
// which are worth drawing.
std::vector<Pose> CandidateAssessor::BestLookAlikes(const OrganizedCloud& cloud,
                                                    const RawHypothesis& start,
                                                    EvidenceScratch& scratch) const {
  std::vector<std::pair<double, Pose>> turned;  // score, then nats; X_CO
  for (const Pose& S_O : look_alikes_[start.object]) {
    const Pose X_CO = start.X_CO * S_O;
    turned.emplace_back(QuickScore(cloud, models_[start.object], X_CO, options_.icp.gate_end_m),
                        X_CO);
  }
  KeepBest(std::max(options_.drawn, options_.look_alikes), turned);
  for (auto& [score, X_CO] : turned) {
    score = evidence_[start.object](cloud, X_CO, scratch).log_ratio;
  }
  KeepBest(options_.look_alikes, turned);
  std::vector<Pose> best;
  for (const auto& [nats, X_CO] : turned) best.push_back(X_CO);
  return best;
}

// `poses` best first, of one part.
void CandidateAssessor::AddLookAlikes(const OrganizedCloud& cloud, EstimateTrace* trace,
                                      std::vector<RawHypothesis>& poses) const {
  constexpr int kStartsAtPlace = 2;
  const size_t most = Turned();
  if (poses.empty()) return;
  const ModelPoints& model = models_[poses.front().object];
  Crowding places(kSamePlaceDiameters * model.diameter_m);
  std::vector<RawHypothesis> starts;
  for (const RawHypothesis& pose : poses) {
    if (starts.size() == most) break;
    const Eigen::Vector3d middle_C = pose.X_CO * model.center_O.cast<double>();
    if (places.Admit(middle_C, kStartsAtPlace)) starts.push_back(pose);
  }
  std::vector<std::vector<Pose>> found(starts.size());
  ForRanges(static_cast<int>(starts.size()), threads_, [&](int begin, int end) {
    EvidenceScratch scratch;
    for (int i = begin; i < end; ++i) found[i] = BestLookAlikes(cloud, starts[i], scratch);
  });
  std::vector<RawHypothesis> turned;
  for (size_t i = 0; i < starts.size(); ++i) {
    for (const Pose& X_CO : found[i]) turned.push_back({starts[i].object, X_CO});
  }
  for (const RawHypothesis& pose : AllRefined(cloud, turned, true, trace)) poses.push_back(pose);
}

std::vector<Candidate> CandidateAssessor::WithFeatures(const OrganizedCloud& cloud,
                                                       const std::vector<RawHypothesis>& poses,
                                                       const VoteDensity& density,
                                                       int patches) const {
  // Votes that agree are more where more patches vote; the verifier sees them as of this many.
  constexpr double kUsualPatches = 600;
  const double per_patch = kUsualPatches / static_cast<double>(patches);
  std::vector<Candidate> candidates(poses.size());
  ForRanges(static_cast<int>(poses.size()), threads_, [&](int begin, int end) {
    EvidenceScratch scratch;
    VoteDensity::Scratch density_scratch;
    for (int i = begin; i < end; ++i) {
      const int part = poses[i].object;
      const Pose& X_CO = poses[i].X_CO;
      Candidate& candidate = candidates[i];
      candidate.hypothesis = {part, X_CO, poses[i].quick_score, {}};
      const DepthEvidence evidence =
          evidence_[part](cloud, X_CO, scratch, options_.evidence_pixels);
      candidate.evidence = evidence.log_ratio;
      candidate.features = ComputeVerifyFeatures(
          cloud, models_[part], X_CO, evidence,
          per_patch * density.Around(X_CO, kNoPatch, density_scratch), candidate.hypothesis.fit);
    }
  });
  return candidates;
}

std::vector<Candidate> CandidateAssessor::Assess(const OrganizedCloud& cloud, int part,
                                                 const std::vector<PoseVote>& votes, int patches,
                                                 double share, StageSeconds& seconds,
                                                 EstimateTrace* trace) const {
  return Assess(cloud, part, votes, votes, patches, share, seconds, trace);
}

std::vector<Candidate> CandidateAssessor::Assess(const OrganizedCloud& cloud, int part,
                                                 const std::vector<PoseVote>& votes,
                                                 const std::vector<PoseVote>& cast, int patches,
                                                 double share, StageSeconds& seconds,
                                                 EstimateTrace* trace) const {
  const int kept = Kept(share);
  std::vector<RawHypothesis> poses;
  {
    const StageTimer timer(seconds, "quick");
    poses = QuickScored(cloud, part, votes);
  }
  std::optional<VoteDensity> density;
  {
    const StageTimer timer(seconds, "select");
    density.emplace(Density(part, cast));
    poses = Selected(std::move(poses), *density, votes, kept);
  }
  {
    const StageTimer timer(seconds, "icp");
    poses = AllRefined(cloud, poses, false, trace);
    poses = Merged(std::move(poses), kept);
  }
  {
    const StageTimer timer(seconds, "look_alikes");
    AddLookAlikes(cloud, trace, poses);
    const size_t all = poses.size();
    poses = Merged(std::move(poses), all);
  }
  const StageTimer timer(seconds, "verify");
  return WithFeatures(cloud, poses, *density, patches);
}

std::vector<int> CandidateAssessor::Unexplained(const OrganizedCloud& cloud,
                                                const std::vector<Candidate>& candidates,
                                                const std::vector<int>& pixels) const {
  std::vector<uint8_t> explained(cloud.points_C.size());
  for (const Candidate* candidate : EvidentCandidates(candidates, models_)) {
    MarkExplained(cloud, models_[candidate->hypothesis.object], candidate->hypothesis.X_CO,
                  explained);
  }
  std::vector<int> left;
  for (const int pixel : pixels) {
    if (!explained[pixel]) left.push_back(pixel);
  }
  return left;
}

void CandidateAssessor::Compare(std::vector<Candidate>& candidates, StageSeconds& seconds) const {
  const StageTimer timer(seconds, "verify");
  std::vector<std::vector<Candidate*>> by_part(objects_.size());
  for (Candidate& candidate : candidates) {
    by_part[candidate.hypothesis.object].push_back(&candidate);
  }
  for (size_t part = 0; part < by_part.size(); ++part) {
    FillMargins(distances_[part], models_[part], by_part[part]);
  }
  const std::vector<const Candidate*> evident = EvidentCandidates(candidates, models_);
  ForRanges(static_cast<int>(candidates.size()), threads_, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      candidates[i].features[kOverlapFeature] =
          static_cast<float>(OverlapWith(evident, candidates[i], models_));
    }
  });
}

}  // namespace pickbed
