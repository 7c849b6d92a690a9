#include "perception/estimators/first_poses.h"

#include <algorithm>
#include <iterator>

#include "perception/candidates/search_regions.h"

namespace pickbed::perception {
namespace {

// Area of a region, in silhouettes of an instance per wanted pose. Not every instance is on top,
// and poses on the border of the region get few votes.
constexpr double kSilhouettesPerPose = 1.5;

Eigen::Vector3d UpOf(const std::optional<KnownBackground>& background) {
  if (background) return background->X_CB.linear().col(2);
  return -Eigen::Vector3d::UnitZ();
}

bool EnoughFound(const std::vector<PoseHypothesis>& hypotheses, const FirstPosesSpec& spec,
                 const EstimatorInput& input) {
  std::vector<PoseHypothesis> confident;
  std::copy_if(hypotheses.begin(), hypotheses.end(), std::back_inserter(confident),
               [&](const PoseHypothesis& pose) { return pose.score >= spec.confidence; });
  if (static_cast<int>(confident.size()) < spec.poses) return false;
  return !input.count_reachable || input.count_reachable(confident, spec.poses) >= spec.poses;
}

}  // namespace

FirstPoses FindFirstPoses(const FirstPosesSearch& search, const OrganizedCloud& cloud,
                          const EstimatorInput& input, Rng& rng, StageSeconds& seconds) {
  FirstPoses found;
  const CandidateRefiner& refiner = search.finder.candidate_refiner();
  const double area_m2 = kSilhouettesPerPose * search.spec.poses * refiner.silhouette_m2();
  SearchRegions regions(cloud, UpOf(input.background), area_m2);
  for (;;) {
    std::vector<int> region;
    {
      const StageTimer timer(seconds, "regions");
      region = regions.Next();
    }
    if (region.empty()) return found;
    for (Candidate& candidate : search.finder.FindIn(cloud, region, rng, seconds, input.trace)) {
      found.candidates.push_back(std::move(candidate));
    }
    refiner.Compare(found.candidates, seconds);
    {
      const StageTimer timer(seconds, "non_maximum_suppression");
      found.hypotheses =
          SelectPoses(cloud, refiner.model_points(), refiner.distances(), search.verifiers,
                      found.candidates, search.pose_selection, input.instances);
    }
    const StageTimer timer(seconds, "reach");
    if (EnoughFound(found.hypotheses, search.spec, input)) return found;
  }
}

}  // namespace pickbed::perception
