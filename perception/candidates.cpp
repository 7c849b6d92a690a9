#include "perception/candidates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

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

ObjectSet ModelsOf(const std::vector<CandidatePart>& parts) {
  ObjectSet models;
  for (const CandidatePart& part : parts) models.push_back(part.model);
  return models;
}

}  // namespace

void CandidateOptions::Visit(SettingsVisitor& v) {
  v.Integer("points", points, {1, 100000}, "patches cut from a frame, of all sizes together");
  v.Integer("min_points", min_points, {1, 100000},
            "patches of each size at least, unless points is less");
  v.Integer("neighbors", neighbors, {1, 1000}, "votes of a patch");
  v.Integer("rounds", rounds, {1, 10}, "of votes; later ones are cast where nothing is explained");
  AssessmentOptions::Visit(v);
  v.Group(
      "index", [&](SettingsVisitor& g) { index.Visit(g); }, "neighbour index");
}

CandidateOptions HardCandidates() {
  CandidateOptions options;
  options.points = 1200;
  options.min_points = 600;
  options.candidates = 600;
  options.two_gates = true;
  options.turned = 40;
  options.look_alikes = 6;
  options.rounds = 2;
  return options;
}

struct CandidateFinder::Impl {
  std::vector<CandidatePart> parts;
  DescribePatches describe;
  CandidateOptions options;
  int threads;
  CandidateAssessor assessor;
  std::vector<SideGroup> groups;

  void BuildGroups();
  void Vote(const SideGroup& group, const OrganizedCloud& cloud, const std::vector<int>& pixels,
            Rng& rng, StageSeconds& seconds, std::vector<std::vector<PoseVote>>& votes,
            EstimateTrace* trace) const;
  // Candidates by votes of some of the pixels.
  std::vector<Candidate> Round(const OrganizedCloud& cloud, const std::vector<int>& looked_at,
                               double share, Rng& rng, StageSeconds& seconds,
                               EstimateTrace* trace) const;
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
      ObjectCodes& codes = parts[p].codes;
      rows.insert(rows.end(), codes.descriptors.begin(), codes.descriptors.end());
      for (size_t i = 0; i < codes.size(); ++i) group.entries.push_back({p, static_cast<int>(i)});
      codes.descriptors = {};  // the index has them now
    }
    group.index = std::make_unique<NeighborIndex>(
        std::move(rows), parts[members.front()].codes.length, options.index);
    groups.push_back(std::move(group));
  }
}

void CandidateFinder::Impl::Vote(const SideGroup& group, const OrganizedCloud& cloud,
                                 const std::vector<int>& pixels, Rng& rng, StageSeconds& seconds,
                                 std::vector<std::vector<PoseVote>>& votes,
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
  const StageTimer timer(seconds, "neighbors");
  const Neighbors found = group.index->Search(descriptors, options.neighbors, threads);
  const int first_patch = trace ? TracePatches(pixels, patches, group.side_m, *trace) : 0;
  for (size_t i = 0; i < found.rows.size(); ++i) {
    if (found.rows[i] < 0) continue;
    const SideGroup::Entry& entry = group.entries[found.rows[i]];
    const int patch = static_cast<int>(i) / options.neighbors;
    votes[entry.part].push_back(
        {patches.X_CP[patch] * CodePose(parts[entry.part].codes, entry.code), patch});
    if (!trace) continue;
    trace->votes.push_back({first_patch + patch,
                            {entry.part, votes[entry.part].back().X_CO},
                            std::sqrt(found.squared[i])});
  }
}

std::vector<Candidate> CandidateFinder::Impl::Round(const OrganizedCloud& cloud,
                                                    const std::vector<int>& looked_at, double share,
                                                    Rng& rng, StageSeconds& seconds,
                                                    EstimateTrace* trace) const {
  const int of_all = std::max(options.min_points, options.points / static_cast<int>(groups.size()));
  const std::vector<int> pixels = SpreadPixels(
      looked_at, static_cast<int>(std::ceil(share * std::min(options.points, of_all))), rng);
  if (pixels.empty()) return {};
  std::vector<std::vector<PoseVote>> votes(parts.size());
  for (const SideGroup& group : groups) Vote(group, cloud, pixels, rng, seconds, votes, trace);
  std::vector<Candidate> candidates;
  for (size_t part = 0; part < votes.size(); ++part) {
    const std::vector<Candidate> of_part =
        assessor.Assess(cloud, static_cast<int>(part), votes[part], static_cast<int>(pixels.size()),
                        share, seconds, trace);
    candidates.insert(candidates.end(), of_part.begin(), of_part.end());
  }
  return candidates;
}

CandidateFinder::CandidateFinder(std::vector<CandidatePart> parts, DescribePatches describe,
                                 const CandidateOptions& options, int threads) {
  CandidateAssessor assessor(ModelsOf(parts), options, threads);
  impl_ = std::make_unique<Impl>(
      Impl{std::move(parts), std::move(describe), options, threads, std::move(assessor), {}});
  impl_->BuildGroups();
}

CandidateFinder::~CandidateFinder() = default;

const CandidateAssessor& CandidateFinder::assessor() const { return impl_->assessor; }

std::vector<Candidate> CandidateFinder::Find(const OrganizedCloud& cloud, Rng& rng,
                                             StageSeconds& seconds, EstimateTrace* trace) const {
  std::vector<Candidate> candidates;
  std::vector<int> unexplained = cloud.foreground_pixels;
  double share = 1;  // of patches and candidates
  for (int round = 0; round < impl_->options.rounds && !unexplained.empty(); ++round) {
    if (round > 0) {
      // What is left is small and hard: twice as many patches to its pixels.
      constexpr double kDenser = 2;
      unexplained = impl_->assessor.Unexplained(cloud, candidates, unexplained);
      share = std::min(1.0, kDenser * static_cast<double>(unexplained.size()) /
                                static_cast<double>(cloud.foreground_pixels.size()));
    }
    for (Candidate& candidate : impl_->Round(cloud, unexplained, share, rng, seconds, trace)) {
      candidates.push_back(candidate);
    }
  }
  impl_->assessor.Compare(candidates, seconds);
  return candidates;
}

}  // namespace pickbed
