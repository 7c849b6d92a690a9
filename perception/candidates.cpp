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
  v.Integer("points", points, {1, 100000}, "patches cut from a frame");
  v.Integer("neighbors", neighbors, {1, 1000}, "votes of a patch");
  AssessmentOptions::Visit(v);
  v.Group(
      "index", [&](SettingsVisitor& g) { index.Visit(g); }, "neighbour index");
}

struct CandidateFinder::Impl {
  std::vector<CandidatePart> parts;
  DescribePatches describe;
  CandidateOptions options;
  CandidateAssessor assessor;
  std::vector<SideGroup> groups;

  void BuildGroups();
  void Vote(const SideGroup& group, const OrganizedCloud& cloud, const std::vector<int>& pixels,
            Rng& rng, StageSeconds& seconds, std::vector<std::vector<PoseVote>>& votes) const;
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
                                 std::vector<std::vector<PoseVote>>& votes) const {
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
  const Neighbors found = group.index->Search(descriptors, options.neighbors);
  for (size_t i = 0; i < found.rows.size(); ++i) {
    if (found.rows[i] < 0) continue;
    const SideGroup::Entry& entry = group.entries[found.rows[i]];
    const int patch = static_cast<int>(i) / options.neighbors;
    votes[entry.part].push_back(
        {patches.X_CP[patch] * CodePose(parts[entry.part].codes, entry.code), patch});
  }
}

CandidateFinder::CandidateFinder(std::vector<CandidatePart> parts, DescribePatches describe,
                                 const CandidateOptions& options) {
  CandidateAssessor assessor(ModelsOf(parts), options);
  impl_ = std::make_unique<Impl>(
      Impl{std::move(parts), std::move(describe), options, std::move(assessor), {}});
  impl_->BuildGroups();
}

CandidateFinder::~CandidateFinder() = default;

const CandidateAssessor& CandidateFinder::assessor() const { return impl_->assessor; }

std::vector<Candidate> CandidateFinder::Find(const OrganizedCloud& cloud, Rng& rng,
                                             StageSeconds& seconds) const {
  const std::vector<int> pixels = SpreadPixels(cloud.foreground_pixels, impl_->options.points, rng);
  if (pixels.empty()) return {};
  std::vector<std::vector<PoseVote>> votes(impl_->parts.size());
  for (const SideGroup& group : impl_->groups) {
    impl_->Vote(group, cloud, pixels, rng, seconds, votes);
  }
  std::vector<Candidate> candidates;
  for (size_t part = 0; part < votes.size(); ++part) {
    const std::vector<Candidate> of_part = impl_->assessor.Assess(
        cloud, static_cast<int>(part), votes[part], static_cast<int>(pixels.size()), seconds);
    candidates.insert(candidates.end(), of_part.begin(), of_part.end());
  }
  return candidates;
}

}  // namespace pickbed
