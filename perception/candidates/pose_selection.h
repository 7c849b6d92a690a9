#pragma once

// Pose selection, from refined candidates to reported hypotheses: the verifier of the object scores
// them, equal poses are merged, and non-maximum suppression removes conflicting ones. The
// estimators and the calibration of their scores share it.

#include <span>
#include <vector>

#include "perception/candidates/candidate_refinement.h"
#include "perception/verify/non_maximum_suppression.h"
#include "perception/voting/pose_clustering.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct PoseSelectionOptions {
  double min_score = 0.5;        // poses with a lower score are not reported
  double merge_diameters = 0.1;  // poses of one object within this pose distance are merged
  CandidateMode mode = CandidateMode::kAccurate;
  NonMaximumSuppressionOptions non_maximum_suppression;
  // Visits all options except `mode`.
  void Visit(SettingsVisitor& v);
};

// Returns the score of each candidate: the verifier's, lowered for an image unlike the training
// images (image_domain.h), divided by the edges of the image among poses with nearly the same depth
// image (edge_comparison.h), and lowered if the surface texture contradicts the pose. The
// texture is compared only for scores of at least options.min_score. `models`, `distances` and
// `verifiers` are by object index.
std::vector<double> CandidateScores(const OrganizedCloud& cloud,
                                    const std::vector<ModelPoints>& models,
                                    const std::vector<PoseDistance>& distances,
                                    std::span<const Verifier> verifiers,
                                    const std::vector<Candidate>& candidates,
                                    const PoseSelectionOptions& options);

// Returns the selected hypotheses by decreasing score. `models`, `distances`, `verifiers` and, if
// not empty, `instances` (see EstimatorInput) are by object index. Throws InputError for options
// out of range.
std::vector<PoseHypothesis> SelectPoses(const OrganizedCloud& cloud,
                                        const std::vector<ModelPoints>& models,
                                        const std::vector<PoseDistance>& distances,
                                        std::span<const Verifier> verifiers,
                                        const std::vector<Candidate>& candidates,
                                        const PoseSelectionOptions& options,
                                        std::span<const int> instances = {});

}  // namespace pickbed::perception
