#include "perception/candidates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "perception/look_alikes.h"
#include "perception/pose_embedding.h"
#include "perception/vote_density.h"
#include "perception/votes.h"

namespace pickbed {
namespace {

// Parts of equal patch side share the patches of a query and one index.
struct SideGroup {
  struct Entry {
    int part = 0;
    int code = 0;
  };
  double side_m = 0;
  std::vector<Entry> entries;  // by row of the index
  std::unique_ptr<NeighborIndex> index;
};

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

// One random pixel of each of `count` equal stretches of the foreground: random, and spread evenly.
std::vector<int> SpreadPixels(const std::vector<int>& foreground, int count, Rng& rng) {
  const size_t total = foreground.size();
  const size_t wanted = std::min<size_t>(total, count);
  std::vector<int> pixels(wanted);
  for (size_t i = 0; i < wanted; ++i) {
    const size_t first = i * total / wanted, last = (i + 1) * total / wanted;
    pixels[i] = foreground[first + rng.Index(static_cast<int>(last - first))];
  }
  return pixels;
}

// A vote with the patch that cast it, so that a patch does not agree with itself.
struct CastVote {
  RawHypothesis hypothesis;
  int patch = 0;
};

}  // namespace

void CandidateOptions::Visit(SettingsVisitor& v) {
  v.Integer("points", points, {1, 100000}, "patches cut from a frame");
  v.Integer("neighbors", neighbors, {1, 1000}, "votes of a patch");
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
  v.Group(
      "index", [&](SettingsVisitor& g) { index.Visit(g); }, "neighbour index");
}

struct CandidateFinder::Impl {
  std::vector<CandidatePart> parts;
  DescribePatches describe;
  CandidateOptions options;
  std::vector<ModelPoints> models;
  std::vector<PoseDistance> distances;
  std::vector<PoseEmbedding> embeddings;
  std::vector<std::vector<Pose>> look_alikes;  // turns S_O, by part
  std::vector<SideGroup> groups;

  void BuildGroups();
  void Vote(const SideGroup& group, const OrganizedCloud& cloud, const std::vector<int>& pixels,
            Rng& rng, StageSeconds& seconds, std::vector<std::vector<CastVote>>& votes,
            EstimateTrace* trace) const;
  RawHypothesis Refined(const OrganizedCloud& cloud, const RawHypothesis& start,
                        EstimateTrace* trace) const;
  VoteDensity Density(int part, const std::vector<CastVote>& votes) const;
  std::vector<RawHypothesis> Selected(const VoteDensity& density,
                                      const std::vector<CastVote>& votes) const;
  void AddLookAlikes(const OrganizedCloud& cloud, std::vector<RawHypothesis>& poses,
                     EstimateTrace* trace) const;
  int Kept() const;
};

void CandidateFinder::Impl::BuildGroups() {
  std::map<long, std::vector<int>> by_side;  // micrometres
  for (size_t p = 0; p < parts.size(); ++p) {
    by_side[std::lround(parts[p].side_m * 1e6)].push_back(static_cast<int>(p));
  }
  for (const auto& [side_um, members] : by_side) {
    SideGroup group;
    group.side_m = parts[members.front()].side_m;
    std::vector<float> rows;
    for (const int p : members) {
      const ObjectCodes& codes = parts[p].codes;
      rows.insert(rows.end(), codes.descriptors.begin(), codes.descriptors.end());
      for (size_t i = 0; i < codes.size(); ++i) group.entries.push_back({p, static_cast<int>(i)});
    }
    group.index = std::make_unique<NeighborIndex>(
        std::move(rows), parts[members.front()].codes.length, options.index);
    groups.push_back(std::move(group));
  }
}

void CandidateFinder::Impl::Vote(const SideGroup& group, const OrganizedCloud& cloud,
                                 const std::vector<int>& pixels, Rng& rng, StageSeconds& seconds,
                                 std::vector<std::vector<CastVote>>& votes,
                                 EstimateTrace* trace) const {
  PatchSet patches;
  {
    const StageTimer timer(seconds, "patches");
    std::vector<double> angles(pixels.size());
    for (double& angle : angles) angle = rng.Uniform(0, 2 * std::numbers::pi);
    patches = CutPatches(cloud, pixels, angles, group.side_m);
  }
  std::vector<float> descriptors;
  {
    const StageTimer timer(seconds, "network");
    descriptors = describe(patches.values);
  }
  Neighbors found;
  {
    const StageTimer timer(seconds, "neighbors");
    found = group.index->Search(descriptors, options.neighbors);
  }
  const int first_patch = trace ? TracePatches(pixels, patches, group.side_m, *trace) : 0;
  const StageTimer timer(seconds, "quick");
  for (size_t i = 0; i < found.rows.size(); ++i) {
    if (found.rows[i] < 0) continue;
    const SideGroup::Entry& entry = group.entries[found.rows[i]];
    RawHypothesis vote;
    vote.object = entry.part;
    vote.X_CO = patches.X_CP[i / options.neighbors] * CodePose(parts[entry.part].codes, entry.code);
    vote.distance = std::sqrt(found.squared[i]);
    vote.quick_score =
        static_cast<float>(QuickScore(cloud, models[entry.part], vote.X_CO, options.quick_tau_m));
    const int patch = static_cast<int>(i) / options.neighbors;
    votes[entry.part].push_back({vote, patch});
    if (trace) trace->votes.push_back({first_patch + patch, vote});
  }
}

// Quick score becomes the score of the refined pose in the fine gate.
RawHypothesis CandidateFinder::Impl::Refined(const OrganizedCloud& cloud,
                                             const RawHypothesis& start,
                                             EstimateTrace* trace) const {
  const ModelPoints& model = models[start.object];
  ProjectiveIcpOptions icp = options.icp;
  const double gate =
      std::clamp(options.gate_diameters * model.diameter_m, options.gate_min_m, options.gate_max_m);
  RawHypothesis best = start;
  for (int run = 0; run < (options.two_gates ? 2 : 1); ++run) {
    icp.gate_m = std::max(run == 0 ? gate : 0.5 * gate, icp.gate_end_m);
    const Pose X_CO = ProjectiveIcp(cloud, model, start.X_CO, icp).X_CO;
    const float score = static_cast<float>(QuickScore(cloud, model, X_CO, icp.gate_end_m));
    if (run > 0 && score <= best.quick_score) continue;
    best.X_CO = X_CO;
    best.quick_score = score;
  }
  if (trace) trace->refinements.push_back({start, best, false});
  return best;
}

// `poses` best first.
void CandidateFinder::Impl::AddLookAlikes(const OrganizedCloud& cloud,
                                          std::vector<RawHypothesis>& poses,
                                          EstimateTrace* trace) const {
  const size_t count = std::min<size_t>(poses.size(), options.turned);
  for (size_t i = 0; i < count; ++i) {
    for (const Pose& S_O : look_alikes[poses[i].object]) {
      RawHypothesis turned = poses[i];
      turned.X_CO = turned.X_CO * S_O;
      poses.push_back(Refined(cloud, turned, trace));
      if (trace) trace->refinements.back().look_alike = true;
    }
  }
}

VoteDensity CandidateFinder::Impl::Density(int part, const std::vector<CastVote>& votes) const {
  std::vector<PoseVote> poses;
  for (const CastVote& vote : votes) poses.push_back({vote.hypothesis.X_CO, vote.patch});
  const ObjectModel& model = *parts[part].model;
  return VoteDensity(embeddings[part], model.mass.com_O, model.diameter_m,
                     options.density_diameters, poses);
}

int CandidateFinder::Impl::Kept() const {
  return std::max(options.min_candidates, options.candidates / static_cast<int>(parts.size()));
}

std::vector<RawHypothesis> CandidateFinder::Impl::Selected(
    const VoteDensity& density, const std::vector<CastVote>& votes) const {
  std::vector<RawHypothesis> ranked;
  for (const CastVote& vote : votes) {
    ranked.push_back(vote.hypothesis);
    const double agreeing = density.Around(vote.hypothesis.X_CO, vote.patch);
    ranked.back().quick_score += static_cast<float>(options.density_weight * std::log1p(agreeing));
  }
  return ClusterVotes(std::move(ranked), distances, options.cluster_diameters, Kept());
}

CandidateFinder::CandidateFinder(std::vector<CandidatePart> parts, DescribePatches describe,
                                 const CandidateOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->parts = std::move(parts);
  impl_->describe = std::move(describe);
  impl_->options = options;
  for (const CandidatePart& part : impl_->parts) {
    impl_->models.push_back(MakeModelPoints(*part.model));
    impl_->distances.emplace_back(*part.model);
    impl_->embeddings.emplace_back(*part.model);
    impl_->look_alikes.push_back(
        LookAlikes(*part.model, impl_->models.back(), impl_->distances.back()));
  }
  impl_->BuildGroups();
}

CandidateFinder::~CandidateFinder() = default;

const std::vector<ModelPoints>& CandidateFinder::model_points() const { return impl_->models; }

std::vector<Candidate> CandidateFinder::Find(const OrganizedCloud& cloud, Rng& rng,
                                             StageSeconds& seconds, EstimateTrace* trace) const {
  const CandidateOptions& options = impl_->options;
  const std::vector<int> pixels = SpreadPixels(cloud.foreground_pixels, options.points, rng);
  if (pixels.empty()) return {};
  std::vector<std::vector<CastVote>> votes(impl_->parts.size());
  for (const SideGroup& group : impl_->groups) {
    impl_->Vote(group, cloud, pixels, rng, seconds, votes, trace);
  }
  // Votes that agree are more where more patches vote; the verifier sees them as of this many.
  constexpr double kUsualPatches = 600;
  const double per_patch = kUsualPatches / static_cast<double>(pixels.size());
  std::vector<Candidate> candidates;
  for (size_t p = 0; p < votes.size(); ++p) {
    const int part = static_cast<int>(p);
    std::vector<RawHypothesis> poses;
    std::optional<VoteDensity> density;
    {
      const StageTimer timer(seconds, "select");
      density.emplace(impl_->Density(part, votes[p]));
      poses = impl_->Selected(*density, votes[p]);
    }
    {
      const StageTimer timer(seconds, "icp");
      for (RawHypothesis& pose : poses) pose = impl_->Refined(cloud, pose, trace);
      poses =
          ClusterVotes(std::move(poses), impl_->distances, options.merge_diameters, impl_->Kept());
      impl_->AddLookAlikes(cloud, poses, trace);
    }
    const StageTimer timer(seconds, "verify");
    std::vector<Candidate> of_part;
    for (const RawHypothesis& pose : poses) {
      Candidate candidate;
      candidate.hypothesis = {part, pose.X_CO, pose.quick_score, {}};
      candidate.features =
          ComputeVerifyFeatures(cloud, impl_->models[p], pose.X_CO,
                                per_patch * density->Around(pose.X_CO), candidate.hypothesis.fit);
      of_part.push_back(candidate);
    }
    FillMargins(impl_->distances[p], impl_->models[p].center_O.cast<double>(), of_part);
    candidates.insert(candidates.end(), of_part.begin(), of_part.end());
  }
  return candidates;
}

}  // namespace pickbed
