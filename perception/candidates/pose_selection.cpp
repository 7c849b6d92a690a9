#include "perception/candidates/pose_selection.h"

#include <algorithm>
#include <cmath>

#include "perception/candidates/edge_comparison.h"
#include "perception/verify/color_consistency.h"
#include "perception/verify/image_domain.h"
#include "scenes/base/finite_counts.h"

namespace pickbed::perception {
namespace {

std::vector<PoseHypothesis> Scored(const OrganizedCloud& cloud,
                                   const std::vector<ModelPoints>& models,
                                   const std::vector<PoseDistance>& distances,
                                   std::span<const Verifier> verifiers,
                                   const std::vector<Candidate>& candidates,
                                   const PoseSelectionOptions& options) {
  const std::vector<double> scores =
      CandidateScores(cloud, models, distances, verifiers, candidates, options);
  std::vector<PoseHypothesis> scored;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (!std::isfinite(scores[i])) CountNotFinite(FiniteBoundary::kScores);
    if (!std::isfinite(scores[i]) || scores[i] < options.min_score) continue;
    scored.push_back(candidates[i].hypothesis);
    scored.back().score = scores[i];
  }
  std::stable_sort(
      scored.begin(), scored.end(),
      [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  return scored;
}

// The score whose logit is lower by `nats`.
double Lowered(double score, double nats) {
  return nats > 0 ? score / (score + (1 - score) * std::exp(nats)) : score;
}

}  // namespace

void PoseSelectionOptions::Visit(SettingsVisitor& v) {
  v.Real("min_score", min_score, {0, 1}, "minimum score of a reported pose");
  v.Real("merge_diameters", merge_diameters, {0, 10},
         "pose distance within which poses of one object are merged, diameters");
  v.RenamedKey("suppress", "non_maximum_suppression");
  v.Group(
      "non_maximum_suppression", [this](SettingsVisitor& g) { non_maximum_suppression.Visit(g); },
      "removal of weaker poses that overlap a stronger one");
}

std::vector<double> CandidateScores(const OrganizedCloud& cloud,
                                    const std::vector<ModelPoints>& models,
                                    const std::vector<PoseDistance>& distances,
                                    std::span<const Verifier> verifiers,
                                    const std::vector<Candidate>& candidates,
                                    const PoseSelectionOptions& options) {
  std::vector<double> scores;
  const ImageDomain domain = DomainOf(cloud);
  for (const Candidate& candidate : candidates) {
    const PoseHypothesis& hypothesis = candidate.hypothesis;
    const double score =
        verifiers[hypothesis.object].Score(candidate.features, options.mode, cloud.background);
    const double diameter_px =
        DiameterInImage_px(cloud.intrinsics, models[hypothesis.object].diameter_m, hypothesis.X_CO);
    const double outside_share =
        OutsideShare(cloud.intrinsics, models[hypothesis.object], hypothesis.X_CO);
    scores.push_back(Lowered(score, LogitPenalty(domain, diameter_px, outside_share)));
  }
  WeighByEdges(cloud, models, distances, candidates, scores);
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (scores[i] < options.min_score) continue;
    const PoseHypothesis& hypothesis = candidates[i].hypothesis;
    scores[i] = ScoreWithTexture(
        scores[i], TextureCorrelation(cloud, models[hypothesis.object], hypothesis.X_CO));
  }
  return scores;
}

std::vector<PoseHypothesis> SelectPoses(const OrganizedCloud& cloud,
                                        const std::vector<ModelPoints>& models,
                                        const std::vector<PoseDistance>& distances,
                                        std::span<const Verifier> verifiers,
                                        const std::vector<Candidate>& candidates,
                                        const PoseSelectionOptions& options,
                                        std::span<const int> instances) {
  CheckSettings("PoseSelectionOptions", options);
  std::vector<PoseHypothesis> kept;
  for (const PoseHypothesis& hypothesis :
       Scored(cloud, models, distances, verifiers, candidates, options)) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PoseHypothesis& better) {
      return better.object == hypothesis.object &&
             distances[hypothesis.object](better.X_CO, hypothesis.X_CO) < options.merge_diameters;
    });
    if (!known) kept.push_back(hypothesis);
  }
  // The common color of an object is estimated from poses of different instances.
  std::vector<PoseHypothesis> accepted =
      SuppressNonMaxima(cloud, models, kept, options.non_maximum_suppression);
  const CommonColors colors(cloud, models, accepted);
  bool any_odd = false;
  for (PoseHypothesis& hypothesis : kept) any_odd |= colors.LowerIfOdd(hypothesis);
  if (!any_odd && instances.empty()) return accepted;
  std::erase_if(kept, [&](const PoseHypothesis& h) { return h.score < options.min_score; });
  return SuppressNonMaxima(cloud, models, std::move(kept), options.non_maximum_suppression,
                           instances);
}

}  // namespace pickbed::perception
