#include "perception/candidates/vote_candidates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "perception/candidates/candidate_comparison.h"
#include "perception/candidates/search_pixels.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr std::string_view kModes = "modes", kRegressed = "regressed", kBoth = "both";

using RawPoses = std::vector<std::vector<PoseVote>>;  // by object

// Objects with equal patch side. They share the patches of a query and one index.
struct SideGroup {
  struct Entry {
    ObjectId object{0};
    int code = 0;
  };
  double side_m = 0;
  std::vector<ObjectId> objects;
  std::vector<Entry> entries;            // by row of the index
  std::unique_ptr<NeighborIndex> index;  // null: poses are only regressed
};

// The vote of one patch with its descriptor distance.
struct PatchVote {
  ObjectId object{0};
  PoseVote vote;
  float distance = 0;
};

// Returns one random pixel from each of `count` equal intervals of the foreground list, so that the
// samples are random but evenly spread.
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

ObjectSet ModelsOf(const std::vector<CandidateObject>& objects) {
  ObjectSet models;
  for (const CandidateObject& object : objects) models.push_back(object.model);
  return models;
}

}  // namespace

void CandidateOptions::Visit(SettingsVisitor& v) {
  v.Integer("points", points, {1, 100000}, "number of patches per image, all patch sizes together");
  v.Integer("min_points", min_points, {1, 100000},
            "minimum number of patches per patch size, limited by points");
  v.Integer("neighbors", neighbors, {1, 1000}, "number of codebook votes per patch");
  v.Text("votes", votes, {"neighbors", "modes", "regressed", "both"}, "source of the raw poses");
  v.RenamedKey("least_share", "min_share");
  v.Real("min_share", min_share, {0, 1},
         "minimum probability that a patch shows the object, for its vote to count");
  v.Integer("rounds", rounds, {1, 10},
            "rounds of voting; later rounds sample only pixels that are not explained");
  v.Integer(
      "crowded_rounds", crowded_rounds, {1, 10},
      "minimum rounds if the background is known and shows clearly more than usual_instances");
  v.Real("later_density", later_density, {0.01, 100},
         "factor of the patches per pixel in later rounds; half of it up to usual_instances");
  CandidateRefinementOptions::Visit(v);
  v.Group(
      "modes", [&](SettingsVisitor& g) { modes.Visit(g); }, "settings that filter votes to modes");
  v.Group(
      "index", [&](SettingsVisitor& g) { index.Visit(g); }, "settings of the neighbor index");
}

CandidateOptions AccurateCandidates() {
  CandidateOptions options;
  options.points = 1200;
  options.min_points = 600;
  options.candidates = 600;
  options.two_correspondence_distances = true;
  options.ambiguous_candidates = 40;
  options.ambiguous_poses = 6;
  options.rivals_of_best = true;
  options.rounds = 2;
  return options;
}

struct CandidateFinder::Impl {
  std::vector<CandidateObject> objects;
  PatchVoter voter;
  CandidateOptions options;
  int threads;
  CandidateRefiner candidate_refiner;
  std::vector<ObjectRotations> rotations;  // by object
  std::vector<PoseTargets> targets;        // by object
  std::vector<SideGroup> groups;
  std::unique_ptr<PoseProposer> proposer;  // may be null
  double largest_diameter_m = 0;           // of the objects

  void BuildGroups();
  // Appends the votes of the patches at the pixels; `votes` is by object.
  void Vote(const SideGroup& group, const OrganizedCloud& cloud, const std::vector<int>& pixels,
            Rng& rng, StageSeconds& seconds, std::vector<std::vector<PatchVote>>& votes,
            EstimateTrace* trace) const;
  std::vector<PatchVote> LookUp(const SideGroup& group, const PatchSet& patches,
                                StageSeconds& seconds) const;
  std::vector<PatchVote> Regress(const SideGroup& group, const PatchSet& patches,
                                 StageSeconds& seconds) const;
  // Votes according to options.votes, grouped by patch.
  std::vector<PatchVote> Cast(const SideGroup& group, const PatchSet& patches,
                              StageSeconds& seconds) const;
  std::vector<PoseVote> ModesOf(ObjectId object, const std::vector<PatchVote>& votes) const;
  // Samples the pixels `visited` and returns candidates from the votes of their patches.
  std::vector<Candidate> Round(const OrganizedCloud& cloud, const std::vector<int>& visited,
                               const SearchEffort& effort, Rng& rng, StageSeconds& seconds,
                               EstimateTrace* trace, const RawPoses& proposed) const;
  // Refines all proposed poses of an object; their density is measured among the votes `cast`.
  void AddProposed(const OrganizedCloud& cloud, ObjectId object,
                   const std::vector<PoseVote>& proposed, const std::vector<PoseVote>& cast,
                   int patches, StageSeconds& seconds, EstimateTrace* trace,
                   std::vector<Candidate>& candidates) const;
};

void CandidateFinder::Impl::BuildGroups() {
  std::map<long, std::vector<ObjectId>> by_side;  // micrometres
  for (size_t p = 0; p < objects.size(); ++p) {
    by_side[std::lround(objects[p].side_m * 1e6)].push_back(ObjectId(p));
  }
  for (const auto& [side_um, members] : by_side) {
    SideGroup group;
    group.side_m = objects[members.front()].side_m;
    group.objects = members;
    if (options.votes == kRegressed) {
      groups.push_back(std::move(group));
      continue;
    }
    std::vector<float> rows;
    for (const ObjectId p : members) {
      ObjectCodes& codes = objects[p].codes;
      rows.insert(rows.end(), codes.descriptors.begin(), codes.descriptors.end());
      for (size_t i = 0; i < codes.size(); ++i) group.entries.push_back({p, static_cast<int>(i)});
      codes.descriptors = {};  // saves memory; the index has a copy
    }
    group.index = std::make_unique<NeighborIndex>(
        std::move(rows), objects[members.front()].codes.length, options.index);
    groups.push_back(std::move(group));
  }
}

std::vector<PatchVote> CandidateFinder::Impl::LookUp(const SideGroup& group,
                                                     const PatchSet& patches,
                                                     StageSeconds& seconds) const {
  std::vector<float> descriptors;
  {
    const StageTimer timer(seconds, "network");
    descriptors = voter.describe(patches.values);
  }
  const StageTimer timer(seconds, "neighbors");
  const Neighbors found = group.index->Search(descriptors, options.neighbors, threads);
  std::vector<PatchVote> votes;
  for (size_t i = 0; i < found.rows.size(); ++i) {
    if (found.rows[i] < 0) continue;
    const SideGroup::Entry& entry = group.entries[found.rows[i]];
    const int patch = static_cast<int>(i) / options.neighbors;
    const Pose X_CO = patches.X_CP[patch] * CodePose(objects[entry.object].codes, entry.code);
    votes.push_back({entry.object, {X_CO, patch}, std::sqrt(found.squared[i])});
  }
  return votes;
}

// Regressed poses get descriptor distance 0.
std::vector<PatchVote> CandidateFinder::Impl::Regress(const SideGroup& group,
                                                      const PatchSet& patches,
                                                      StageSeconds& seconds) const {
  const StageTimer timer(seconds, "network");
  const std::vector<float> values = voter.regress(patches.values);
  std::vector<PatchVote> votes;
  for (size_t patch = 0; patch < patches.size(); ++patch) {
    for (const ObjectId object : group.objects) {
      const size_t row = patch * voter.object_count + objects[object].trained;
      const std::span<const float> said(values.data() + row * kPoseValues, kPoseValues);
      if (said[0] < options.min_share) continue;
      votes.push_back(
          {object, {patches.X_CP[patch] * targets[object].PoseOf(said), static_cast<int>(patch)}});
    }
  }
  return votes;
}

std::vector<PatchVote> CandidateFinder::Impl::Cast(const SideGroup& group, const PatchSet& patches,
                                                   StageSeconds& seconds) const {
  if (options.votes == kRegressed) return Regress(group, patches, seconds);
  std::vector<PatchVote> votes = LookUp(group, patches, seconds);
  if (options.votes != kBoth) return votes;
  const std::vector<PatchVote> regressed = Regress(group, patches, seconds);
  votes.insert(votes.end(), regressed.begin(), regressed.end());
  std::stable_sort(votes.begin(), votes.end(), [](const PatchVote& a, const PatchVote& b) {
    return a.vote.patch < b.vote.patch;
  });
  return votes;
}

void CandidateFinder::Impl::Vote(const SideGroup& group, const OrganizedCloud& cloud,
                                 const std::vector<int>& pixels, Rng& rng, StageSeconds& seconds,
                                 std::vector<std::vector<PatchVote>>& votes,
                                 EstimateTrace* trace) const {
  PatchSet patches;
  {
    const StageTimer timer(seconds, "patches");
    std::vector<double> angles(pixels.size());
    for (double& angle : angles) angle = rng.Uniform(0, 2 * std::numbers::pi);
    patches = CutPatches(cloud, pixels, angles, {group.side_m, voter.channels});
  }
  const int first_patch = trace ? TracePatches(pixels, patches, group.side_m, *trace) : 0;
  for (const PatchVote& cast : Cast(group, patches, seconds)) {
    votes[cast.object].push_back(cast);
    if (!trace) continue;
    trace->votes.push_back(
        {first_patch + cast.vote.patch, {cast.object, cast.vote.X_CO}, cast.distance});
  }
}

std::vector<PoseVote> CandidateFinder::Impl::ModesOf(ObjectId object,
                                                     const std::vector<PatchVote>& votes) const {
  std::vector<CastVote> cast;
  for (const PatchVote& vote : votes) cast.push_back({vote.vote.X_CO, vote.distance});
  std::vector<PoseVote> modes;
  for (const VoteMode& mode :
       FindVoteModes(*objects[object].model, rotations[object], cast, options.modes)) {
    modes.push_back({mode.X_CO, kNoPatch});
  }
  return modes;
}

std::vector<Candidate> CandidateFinder::Impl::Round(const OrganizedCloud& cloud,
                                                    const std::vector<int>& visited,
                                                    const SearchEffort& effort, Rng& rng,
                                                    StageSeconds& seconds, EstimateTrace* trace,
                                                    const RawPoses& proposed) const {
  const int of_all = std::max(options.min_points, options.points / static_cast<int>(groups.size()));
  const double points = effort.scene * effort.share * std::min(options.points, of_all);
  const std::vector<int> pixels = SpreadPixels(visited, static_cast<int>(std::ceil(points)), rng);
  if (pixels.empty()) return {};
  std::vector<std::vector<PatchVote>> votes(objects.size());
  for (const SideGroup& group : groups) Vote(group, cloud, pixels, rng, seconds, votes, trace);
  std::vector<Candidate> candidates;
  for (size_t p = 0; p < votes.size(); ++p) {
    const ObjectId object(p);
    const int patches = static_cast<int>(pixels.size());
    std::vector<PoseVote> cast, poses;
    for (const PatchVote& vote : votes[p]) cast.push_back(vote.vote);
    if (options.votes == kModes) {
      const StageTimer timer(seconds, "modes");
      poses = ModesOf(object, votes[p]);
    }
    const std::vector<Candidate> of_object =
        candidate_refiner.RefineCandidates(cloud, object, options.votes == kModes ? poses : cast,
                                           cast, patches, effort, seconds, trace);
    candidates.insert(candidates.end(), of_object.begin(), of_object.end());
    if (p < proposed.size()) {
      AddProposed(cloud, object, proposed[p], cast, patches, seconds, trace, candidates);
    }
  }
  return candidates;
}

void CandidateFinder::Impl::AddProposed(const OrganizedCloud& cloud, ObjectId object,
                                        const std::vector<PoseVote>& proposed,
                                        const std::vector<PoseVote>& cast, int patches,
                                        StageSeconds& seconds, EstimateTrace* trace,
                                        std::vector<Candidate>& candidates) const {
  if (proposed.empty()) return;
  const int usual =
      std::max(options.min_candidates, options.candidates / static_cast<int>(objects.size()));
  const SearchEffort effort{static_cast<double>(proposed.size()) / usual, 1};
  for (const Candidate& candidate : candidate_refiner.RefineCandidates(
           cloud, object, proposed, cast, patches, effort, seconds, trace)) {
    candidates.push_back(candidate);
  }
}

CandidateFinder::CandidateFinder(std::vector<CandidateObject> objects, PatchVoter voter,
                                 const CandidateOptions& options, int threads,
                                 std::unique_ptr<PoseProposer> proposer) {
  CheckSettings("CandidateOptions", options);
  const bool regresses = options.votes == kRegressed || options.votes == kBoth;
  CheckInput(!regresses || voter.regress,
             "candidates.votes: the network regresses no poses; set candidates.votes to neighbors "
             "or modes");
  CandidateRefiner candidate_refiner(ModelsOf(objects), options, threads);
  std::vector<ObjectRotations> rotations;
  std::vector<PoseTargets> targets;
  for (const CandidateObject& object : objects) {
    rotations.emplace_back(object.model->symmetries_O);
    targets.emplace_back(*object.model, object.side_m);
  }
  impl_ = std::make_unique<Impl>(Impl{std::move(objects),
                                      std::move(voter),
                                      options,
                                      threads,
                                      std::move(candidate_refiner),
                                      std::move(rotations),
                                      std::move(targets),
                                      {},
                                      std::move(proposer)});
  for (const CandidateObject& object : impl_->objects) {
    impl_->largest_diameter_m = std::max(impl_->largest_diameter_m, object.model->diameter_m);
  }
  impl_->BuildGroups();
}

CandidateFinder::~CandidateFinder() = default;

const CandidateRefiner& CandidateFinder::candidate_refiner() const {
  return impl_->candidate_refiner;
}

std::vector<Candidate> CandidateFinder::Find(const OrganizedCloud& cloud, Rng& rng,
                                             StageSeconds& seconds, EstimateTrace* trace) const {
  RequireChannels(cloud, impl_->voter.channels);  // throws even if no patch is cut
  if (trace) trace->channels = impl_->voter.channels;
  const CandidateOptions& options = impl_->options;
  std::vector<Candidate> candidates;
  std::vector<int> unexplained = SearchPixels(cloud, impl_->largest_diameter_m);
  const auto searched = static_cast<double>(unexplained.size());
  SearchEffort effort{impl_->candidate_refiner.SceneEffort(cloud, unexplained), 1};
  RawPoses proposed;
  if (impl_->proposer) proposed = impl_->proposer->Propose(cloud, seconds);
  const bool may_be_crowded = cloud.background == BackgroundKind::kKnown && effort.scene > 1;
  const int rounds =
      may_be_crowded ? std::max(options.rounds, options.crowded_rounds) : options.rounds;
  for (int round = 0; round < rounds && !unexplained.empty(); ++round) {
    if (round >= options.rounds) {
      // Twenty bolts can cover as many pixels as 23, and a few wrong poses are found beside them.
      constexpr double kMaxArea = 1.2, kMaxFound = 1.1;
      const std::vector<ModelPoints>& models = impl_->candidate_refiner.model_points();
      const auto found = static_cast<double>(EvidentCandidates(candidates, models).size());
      if (effort.scene <= kMaxArea && found <= kMaxFound * options.usual_instances) break;
    }
    if (round > 0) {
      // The remaining pixels are few and difficult, so they get patches of their own density.
      unexplained = impl_->candidate_refiner.Unexplained(cloud, candidates, unexplained);
      // In a scene that is not crowded, more patches take time and find little.
      const double density = (effort.scene > 1 ? 1 : 0.5) * options.later_density;
      effort.share = std::min(1.0, density * static_cast<double>(unexplained.size()) / searched);
    }
    for (Candidate& candidate :
         impl_->Round(cloud, unexplained, effort, rng, seconds, trace, proposed)) {
      candidates.push_back(candidate);
    }
    proposed.clear();  // only once
  }
  impl_->candidate_refiner.Compare(candidates, seconds);
  return candidates;
}

std::vector<Candidate> CandidateFinder::FindIn(const OrganizedCloud& cloud,
                                               const std::vector<int>& pixels, Rng& rng,
                                               StageSeconds& seconds, EstimateTrace* trace) const {
  RequireChannels(cloud, impl_->voter.channels);
  if (trace) trace->channels = impl_->voter.channels;
  if (pixels.empty()) return {};
  // A region is a small scene: its patches are as dense as in a search of the whole foreground.
  const double share = static_cast<double>(pixels.size()) /
                       static_cast<double>(std::max<size_t>(1, cloud.foreground_pixels.size()));
  const SearchEffort effort{
      share * impl_->candidate_refiner.SceneEffort(cloud, cloud.foreground_pixels), 1};
  return impl_->Round(cloud, pixels, effort, rng, seconds, trace, {});
}

}  // namespace pickbed::perception
