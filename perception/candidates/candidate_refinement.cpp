#include "perception/candidates/candidate_refinement.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "perception/candidates/search_effort.h"
#include "perception/model/ambiguous_poses.h"
#include "perception/verify/physical_consistency.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

struct ScoredPose {
  double score = 0;
  Pose X_CO = Pose::Identity();
};

// Sorts by decreasing score, stable, and keeps the first `max_count`.
void KeepBest(size_t max_count, std::vector<ScoredPose>& scored) {
  std::stable_sort(scored.begin(), scored.end(),
                   [](const ScoredPose& a, const ScoredPose& b) { return a.score > b.score; });
  if (scored.size() > max_count) scored.resize(max_count);
}

}  // namespace

void CandidateRefinementOptions::Visit(SettingsVisitor& v) {
  v.Real("usual_instances", usual_instances, {1, 1e6},
         "number of visible instances up to which the numbers of patches and candidates hold; a "
         "scene that shows more gets proportionally more");
  v.Integer("candidates", candidates, {1, 100000},
            "maximum number of refined poses, all objects together");
  v.Integer("min_candidates", min_candidates, {1, 100000},
            "minimum number of refined poses per object");
  v.Real("fitted_background_factor", fitted_background_factor, {1, 100},
         "factor of the numbers of refined and ambiguous poses if the background is not given, but "
         "planes are found");
  v.Real("quick_tau_m", quick_tau_m, {1e-4, 0.1}, "depth band of the quick score, m");
  v.Real("density_weight", density_weight, {0, 10},
         "weight of the vote density in the rank of a vote");
  v.Real("density_diameters", density_diameters, {1e-3, 1},
         "kernel radius of the vote density, diameters");
  v.Real("cluster_diameters", cluster_diameters, {1e-4, 1},
         "pose distance within which raw poses are merged, diameters");
  v.RenamedKey("gate_diameters", "correspondence_distance_diameters");
  v.Real("correspondence_distance_diameters", correspondence_distance_diameters, {1e-3, 1},
         "maximum correspondence distance at the start of ICP, diameters");
  v.RenamedKey("gate_min_m", "min_correspondence_distance_m");
  v.Real("min_correspondence_distance_m", min_correspondence_distance_m, {1e-4, 1},
         "lower limit of the correspondence distance, m");
  v.RenamedKey("gate_max_m", "max_correspondence_distance_m");
  v.Real("max_correspondence_distance_m", max_correspondence_distance_m, {1e-4, 1},
         "upper limit of the correspondence distance, m");
  v.RenamedKey("two_gates", "two_correspondence_distances");
  v.Bool("two_correspondence_distances", two_correspondence_distances,
         "whether half the correspondence distance is also tried and the better result kept");
  v.RenamedKey("turned", "ambiguous_candidates");
  v.Integer("ambiguous_candidates", ambiguous_candidates, {0, 100000},
            "number of best poses, all objects together, whose ambiguous poses are tried");
  v.RenamedKey("look_alikes", "ambiguous_poses");
  v.Integer("ambiguous_poses", ambiguous_poses, {1, 1000},
            "number of ambiguous poses refined per pose");
  v.Integer("drawn", drawn, {1, 1000},
            "number of ambiguous poses per pose whose evidence is measured");
  v.Bool("rivals_of_best", rivals_of_best,
         "whether the ambiguous poses of the pose with most evidence at each place are tried, too");
  v.RenamedKey("least_quick_score", "min_quick_score");
  v.Real("min_quick_score", min_quick_score, {-1, 1}, "minimum quick score of a refined pose");
  v.Integer("fine_points", fine_points, {6, 512}, "number of points in the second refinement");
  v.Integer("fine_steps", fine_steps, {0, 100}, "number of iterations in the second refinement");
  v.Integer("evidence_pixels", evidence_pixels, {1, 1000000},
            "approximate number of pixels evaluated per candidate");
  v.Real("merge_diameters", merge_diameters, {1e-4, 1},
         "pose distance within which refined poses are merged, diameters");
}

CandidateRefiner::CandidateRefiner(const ObjectSet& objects,
                                   const CandidateRefinementOptions& options, int threads)
    : objects_(objects), options_(options), threads_(threads) {
  CheckSettings("CandidateRefinementOptions", options);
  CheckSettings("ProjectiveIcpOptions", options.icp);
  for (const auto& object : objects_) {
    models_.push_back(MakeModelPoints(*object));
    evidence_.emplace_back(*object);
    distances_.emplace_back(*object);
    embeddings_.emplace_back(*object);
    ambiguous_poses_.push_back(AmbiguousPoses(*object, models_.back(), distances_.back()));
    silhouette_m2_ += LargestSilhouette_m2(models_.back()) / static_cast<double>(objects_.size());
  }
}

std::vector<RawHypothesis> CandidateRefiner::QuickScored(const OrganizedCloud& cloud,
                                                         ObjectId object,
                                                         const std::vector<PoseVote>& votes) const {
  std::vector<RawHypothesis> scored(votes.size());
  ForRanges(static_cast<int>(votes.size()), threads_, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Pose& X_CO = votes[i].X_CO;
      const double score = QuickScore(cloud, models_[object], X_CO, options_.quick_tau_m);
      scored[i] = {.object = object,
                   .X_CO = X_CO,
                   .quick_score = static_cast<float>(score),
                   .patch = votes[i].patch};
    }
  });
  return scored;
}

VoteDensity CandidateRefiner::Density(ObjectId object, const std::vector<PoseVote>& votes) const {
  const ObjectModel& model = *objects_[object];
  return VoteDensity(embeddings_[object], model.mass.com_O, model.diameter_m,
                     options_.density_diameters, votes);
}

double CandidateRefiner::SceneEffort(const OrganizedCloud& cloud,
                                     const std::vector<int>& pixels) const {
  // Without a known background, a wide foreground says little about the number of instances.
  constexpr double kMaxEffort = 10, kMaxEffortUnknown = 4;
  if (!(silhouette_m2_ > 0)) return 1;
  const double instances = AreaOf_m2(cloud, pixels) / silhouette_m2_;
  const bool is_known = cloud.background == BackgroundKind::kKnown;
  return std::clamp(instances / options_.usual_instances, 1.0,
                    is_known ? kMaxEffort : kMaxEffortUnknown);
}

int CandidateRefiner::Kept(const SearchEffort& effort) const {
  const int all =
      std::max(options_.min_candidates, options_.candidates / static_cast<int>(objects_.size()));
  return std::max(1, static_cast<int>(effort.scene * effort.share * all));
}

// Objects in the same bin share the number of tried poses in the same ratio as the candidates.
int CandidateRefiner::AmbiguousStarts(double scene_effort) const {
  const double of_all = static_cast<double>(Kept({})) / options_.candidates;
  return static_cast<int>(
      std::ceil(scene_effort * options_.ambiguous_candidates * std::min(1.0, of_all)));
}

// Votes of the same patch do not add to the density.
std::vector<RawHypothesis> CandidateRefiner::Selected(std::vector<RawHypothesis> scored,
                                                      const VoteDensity& density, int kept) const {
  ForRanges(static_cast<int>(scored.size()), threads_, [&](int begin, int end) {
    VoteDensity::Scratch scratch;
    for (int i = begin; i < end; ++i) {
      RawHypothesis& pose = scored[i];
      const double agreeing = density.Around(pose.X_CO, pose.patch, scratch);
      pose.quick_score += static_cast<float>(options_.density_weight * std::log1p(agreeing));
    }
  });
  return ClusterVotes(std::move(scored), distances_, options_.cluster_diameters, kept);
}

// The new quick score uses the final correspondence distance as band. If ICP lowers it, the start
// pose is kept.
RawHypothesis CandidateRefiner::Refined(const OrganizedCloud& cloud,
                                        const RawHypothesis& start) const {
  const ModelPoints& model = models_[start.object];
  ProjectiveIcpOptions icp = options_.icp;
  const double final_m = icp.final_correspondence_distance_m;
  const double first_m =
      std::clamp(options_.correspondence_distance_diameters * model.diameter_m,
                 options_.min_correspondence_distance_m, options_.max_correspondence_distance_m);
  RawHypothesis best = start;
  best.quick_score = static_cast<float>(QuickScore(cloud, model, start.X_CO, final_m));
  for (int run = 0; run < (options_.two_correspondence_distances ? 2 : 1); ++run) {
    icp.max_correspondence_distance_m = std::max(run == 0 ? first_m : 0.5 * first_m, final_m);
    const Pose X_CO = ProjectiveIcpUnchecked(cloud, model, start.X_CO, icp).X_CO;
    const float score = static_cast<float>(QuickScore(cloud, model, X_CO, final_m));
    if (score < best.quick_score || (run > 0 && score == best.quick_score)) continue;
    best.X_CO = X_CO;
    best.quick_score = score;
  }
  if (best.quick_score >= options_.min_quick_score) RefineFinely(cloud, best);
  return best;
}

// With the few points of the first iterations, an ambiguous pose sometimes scores higher than the
// true pose.
void CandidateRefiner::RefineFinely(const OrganizedCloud& cloud, RawHypothesis& pose) const {
  constexpr float kMaxLoss = 0.05f;  // tolerated loss; the quick score counts whole points
  const ModelPoints& model = models_[pose.object];
  ProjectiveIcpOptions icp = options_.icp;
  icp.coarse_iterations = 0;
  icp.fine_iterations = options_.fine_steps;
  icp.max_points = options_.fine_points;
  const Pose X_CO = ProjectiveIcpUnchecked(cloud, model, pose.X_CO, icp).X_CO;
  const float score =
      static_cast<float>(QuickScore(cloud, model, X_CO, icp.final_correspondence_distance_m));
  if (score < pose.quick_score - kMaxLoss) return;
  pose.X_CO = X_CO;
  pose.quick_score = score;
}

std::vector<RawHypothesis> CandidateRefiner::AllRefined(const OrganizedCloud& cloud,
                                                        const std::vector<RawHypothesis>& starts,
                                                        bool ambiguous_poses,
                                                        EstimateTrace* trace) const {
  std::vector<RawHypothesis> refined(starts.size());
  ForRanges(static_cast<int>(starts.size()), threads_, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) refined[i] = Refined(cloud, starts[i]);
  });
  for (size_t i = 0; trace && i < starts.size(); ++i) {
    trace->refinements.push_back({starts[i], refined[i], ambiguous_poses});
  }
  return refined;
}

// Drops poses with a low quick score and merges nearly equal ones.
std::vector<RawHypothesis> CandidateRefiner::Merged(std::vector<RawHypothesis> poses,
                                                    size_t max_count) const {
  std::erase_if(poses, [&](const RawHypothesis& pose) {
    return pose.quick_score < options_.min_quick_score;
  });
  return ClusterVotes(std::move(poses), distances_, options_.merge_diameters,
                      static_cast<int>(max_count));
}

// Returns the ambiguous poses with most evidence, best first. The quick score preselects them,
// because it costs a tenth of the evidence. Poses that penetrate the floor or a wall deeply are
// left out. Their wrong part is hidden behind it, so the evidence does not count against them, and
// they would take the places of others.
std::vector<RawHypothesis> CandidateRefiner::BestAmbiguousPoses(const OrganizedCloud& cloud,
                                                                const RawHypothesis& start,
                                                                EvidenceScratch& scratch) const {
  constexpr double kMaxOutsideDiameters = 0.1;  // maximum penetration of a pose that is tried
  const double band_m = options_.icp.final_correspondence_distance_m;
  const ModelPoints& model = models_[start.object];
  std::vector<ScoredPose> by_quick_score;
  for (const Pose& S_O : ambiguous_poses_[start.object]) {
    const Pose X_CO = start.X_CO * S_O;
    by_quick_score.push_back({QuickScore(cloud, model, X_CO, band_m), X_CO});
  }
  KeepBest(by_quick_score.size(), by_quick_score);
  const size_t max_count = std::max(options_.drawn, options_.ambiguous_poses);
  std::vector<ScoredPose> rotated;  // the score is the evidence in nats
  for (const ScoredPose& pose : by_quick_score) {
    if (rotated.size() == max_count) break;
    const Containment contained = MeasureContainment(cloud, model, pose.X_CO);
    if (contained.outside_m <= kMaxOutsideDiameters * model.diameter_m) rotated.push_back(pose);
  }
  for (ScoredPose& pose : rotated) {
    pose.score = evidence_[start.object](cloud, pose.X_CO, scratch).log_ratio;
  }
  KeepBest(options_.ambiguous_poses, rotated);
  std::vector<RawHypothesis> best;
  for (const ScoredPose& pose : rotated) best.push_back({start.object, pose.X_CO});
  return best;
}

// Returns the first poses at each place. `poses` are of one object, best first.
std::vector<RawHypothesis> CandidateRefiner::BestAtEachPlace(
    const std::vector<RawHypothesis>& poses, int max_at_place, int max_count) const {
  std::vector<RawHypothesis> best;
  if (poses.empty()) return best;
  const ModelPoints& model = models_[poses.front().object];
  Crowding places(kSamePlaceDiameters * model.diameter_m);
  for (const RawHypothesis& pose : poses) {
    if (static_cast<int>(best.size()) == max_count) break;
    const Eigen::Vector3d center_C = pose.X_CO * model.center_O.cast<double>();
    if (places.Admit(center_C, max_at_place)) best.push_back(pose);
  }
  return best;
}

std::vector<RawHypothesis> CandidateRefiner::RefinedAmbiguousPoses(
    const OrganizedCloud& cloud, const std::vector<RawHypothesis>& starts,
    EstimateTrace* trace) const {
  std::vector<std::vector<RawHypothesis>> found(starts.size());
  ForRanges(static_cast<int>(starts.size()), threads_, [&](int begin, int end) {
    EvidenceScratch scratch;
    for (int i = begin; i < end; ++i) found[i] = BestAmbiguousPoses(cloud, starts[i], scratch);
  });
  std::vector<RawHypothesis> rotated;
  for (const std::vector<RawHypothesis>& of_start : found) {
    rotated.insert(rotated.end(), of_start.begin(), of_start.end());
  }
  return AllRefined(cloud, rotated, true, trace);
}

// Whether one of the poses is within this distance, in diameters.
bool CandidateRefiner::IsNearAny(const RawHypothesis& pose,
                                 const std::vector<RawHypothesis>& others, double diameters) const {
  const PoseDistance& distance = distances_[pose.object];
  const Eigen::Vector3d center_O = models_[pose.object].center_O.cast<double>();
  const Eigen::Vector3d center_C = pose.X_CO * center_O;
  const double max_m = diameters * distance.diameter_m();
  return std::any_of(others.begin(), others.end(), [&](const RawHypothesis& other) {
    return (other.X_CO * center_O - center_C).norm() < max_m &&
           distance(pose.X_CO, other.X_CO) < diameters;
  });
}

// The starts have the best quick scores, which says little about their evidence. If the pose with
// most evidence at a place was no start, its ambiguous poses are its strongest rivals, and they are
// missing. Then it gets a high score without being compared with them.
std::vector<RawHypothesis> CandidateRefiner::MissingRivals(const OrganizedCloud& cloud,
                                                           const std::vector<RawHypothesis>& starts,
                                                           const std::vector<Candidate>& candidates,
                                                           EstimateTrace* trace) const {
  constexpr double kSamePoseDiameters = 0.1;
  std::vector<const Candidate*> by_evidence;
  for (const Candidate& candidate : candidates) by_evidence.push_back(&candidate);
  std::stable_sort(
      by_evidence.begin(), by_evidence.end(),
      [](const Candidate* a, const Candidate* b) { return a->evidence > b->evidence; });
  std::vector<RawHypothesis> poses;
  for (const Candidate* candidate : by_evidence) {
    poses.push_back({candidate->hypothesis.object, candidate->hypothesis.X_CO});
  }
  std::vector<RawHypothesis> best = BestAtEachPlace(poses, 1, static_cast<int>(starts.size()));
  std::erase_if(
      best, [&](const RawHypothesis& pose) { return IsNearAny(pose, starts, kSamePoseDiameters); });
  std::vector<RawHypothesis> rivals = RefinedAmbiguousPoses(cloud, best, trace);
  std::erase_if(rivals, [&](const RawHypothesis& rival) {
    return IsNearAny(rival, poses, options_.merge_diameters);
  });
  const size_t all = rivals.size();
  return Merged(std::move(rivals), all);
}

std::vector<Candidate> CandidateRefiner::WithFeatures(const OrganizedCloud& cloud,
                                                      const std::vector<RawHypothesis>& poses,
                                                      const VoteDensity& density,
                                                      double patches) const {
  // The density grows with the number of patches; the verifier gets it scaled to this number.
  constexpr double kUsualPatches = 600;
  const double per_patch = kUsualPatches / patches;
  std::vector<Candidate> candidates(poses.size());
  ForRanges(static_cast<int>(poses.size()), threads_, [&](int begin, int end) {
    EvidenceScratch scratch;
    VoteDensity::Scratch density_scratch;
    PoseSupportMeasure support;
    for (int i = begin; i < end; ++i) {
      const ObjectId object = poses[i].object;
      const Pose& X_CO = poses[i].X_CO;
      Candidate& candidate = candidates[i];
      candidate.hypothesis = {object, X_CO, poses[i].quick_score, {}};
      const DepthEvidence evidence =
          evidence_[object](cloud, X_CO, scratch, options_.evidence_pixels, &support);
      candidate.evidence = evidence.log_ratio;
      candidate.features = ComputeVerifyFeatures(
          cloud, models_[object], X_CO, evidence, support.Finish(),
          per_patch * density.Around(X_CO, kNoPatch, density_scratch), candidate.hypothesis.fit);
    }
  });
  return candidates;
}

std::vector<Candidate> CandidateRefiner::RefineCandidates(
    const OrganizedCloud& cloud, ObjectId object, const std::vector<PoseVote>& votes, int patches,
    const SearchEffort& effort, StageSeconds& seconds, EstimateTrace* trace) const {
  return RefineCandidates(cloud, object, votes, votes, patches, effort, seconds, trace);
}

std::vector<Candidate> CandidateRefiner::RefineCandidates(
    const OrganizedCloud& cloud, ObjectId object, const std::vector<PoseVote>& votes,
    const std::vector<PoseVote>& cast, int patches, const SearchEffort& effort,
    StageSeconds& seconds, EstimateTrace* trace) const {
  constexpr int kStartsAtPlace = 2;  // poses at one place whose ambiguous poses are tried
  const bool is_fitted = cloud.background == BackgroundKind::kFitted;
  const double scene = (is_fitted ? options_.fitted_background_factor : 1) * effort.scene;
  const int kept = Kept({.scene = scene, .share = effort.share});
  std::vector<RawHypothesis> poses, starts;
  {
    const StageTimer timer(seconds, "quick");
    poses = QuickScored(cloud, object, votes);
  }
  std::optional<VoteDensity> density;
  {
    const StageTimer timer(seconds, "select");
    density.emplace(Density(object, cast));
    poses = Selected(std::move(poses), *density, kept);
  }
  {
    const StageTimer timer(seconds, "icp");
    poses = AllRefined(cloud, poses, false, trace);
    poses = Merged(std::move(poses), kept);
  }
  {
    const StageTimer timer(seconds, "ambiguous_poses");
    starts = BestAtEachPlace(poses, kStartsAtPlace, AmbiguousStarts(scene));
    for (const RawHypothesis& pose : RefinedAmbiguousPoses(cloud, starts, trace)) {
      poses.push_back(pose);
    }
    const size_t all = poses.size();
    poses = Merged(std::move(poses), all);
  }
  std::vector<Candidate> candidates;
  const auto add = [&](const std::vector<RawHypothesis>& more) {
    const StageTimer timer(seconds, "verify");
    for (Candidate& candidate : WithFeatures(cloud, more, *density, patches / effort.scene)) {
      candidates.push_back(std::move(candidate));
    }
  };
  add(poses);
  if (!options_.rivals_of_best) return candidates;
  std::vector<RawHypothesis> rivals;
  {
    const StageTimer timer(seconds, "ambiguous_poses");
    rivals = MissingRivals(cloud, starts, candidates, trace);
  }
  add(rivals);
  return candidates;
}

std::vector<int> CandidateRefiner::Unexplained(const OrganizedCloud& cloud,
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

void CandidateRefiner::Compare(std::vector<Candidate>& candidates, StageSeconds& seconds) const {
  const StageTimer timer(seconds, "verify");
  std::vector<std::vector<Candidate*>> by_object(objects_.size());
  for (Candidate& candidate : candidates) {
    by_object[candidate.hypothesis.object].push_back(&candidate);
  }
  for (size_t object = 0; object < by_object.size(); ++object) {
    FillMargins(distances_[object], models_[object], by_object[object]);
  }
  const std::vector<const Candidate*> evident = EvidentCandidates(candidates, models_);
  ForRanges(static_cast<int>(candidates.size()), threads_, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      candidates[i].features[kOverlapFeature] =
          static_cast<float>(OverlapWith(evident, candidates[i], models_));
    }
  });
}

}  // namespace pickbed::perception
