#include "perception/final_set.h"

#include <algorithm>

namespace pickbed {
namespace {

std::vector<PoseHypothesis> Scored(std::span<const Verifier> verifiers,
                                   const std::vector<Candidate>& candidates,
                                   const FinalSetOptions& options) {
  std::vector<PoseHypothesis> scored;
  for (const Candidate& candidate : candidates) {
    PoseHypothesis hypothesis = candidate.hypothesis;
    hypothesis.score = verifiers[hypothesis.object].Score(candidate.features, options.mode);
    if (hypothesis.score >= options.min_score) scored.push_back(hypothesis);
  }
  std::stable_sort(
      scored.begin(), scored.end(),
      [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  return scored;
}

}  // namespace

std::vector<PoseHypothesis> FinalSet(const OrganizedCloud& cloud,
                                     const std::vector<ModelPoints>& models,
                                     const std::vector<PoseDistance>& distances,
                                     std::span<const Verifier> verifiers,
                                     const std::vector<Candidate>& candidates,
                                     const FinalSetOptions& options,
                                     std::span<const int> instances) {
  std::vector<PoseHypothesis> kept;
  for (const PoseHypothesis& hypothesis : Scored(verifiers, candidates, options)) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PoseHypothesis& better) {
      return better.object == hypothesis.object &&
             distances[hypothesis.object](better.X_CO, hypothesis.X_CO) < options.merge_diameters;
    });
    if (!known) kept.push_back(hypothesis);
  }
  return SuppressDuplicates(cloud, models, std::move(kept), options.suppress, instances);
}

}  // namespace pickbed
