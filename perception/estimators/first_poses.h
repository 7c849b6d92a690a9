#pragma once

// Search mode "first": a few sure poses on top of the pile, as soon as possible. It searches
// regions of the foreground, the highest first, and stops when enough confident poses are found
// that a grasp can reach.

#include <span>

#include "perception/candidates/pose_selection.h"
#include "perception/candidates/vote_candidates.h"
#include "perception/estimators/pose_estimator.h"

namespace pickbed::perception {

// Parts of an estimator that the search uses. References must outlive the call.
struct FirstPosesSearch {
  const CandidateFinder& finder;
  std::span<const Verifier> verifiers;  // by object
  const PoseSelectionOptions& pose_selection;
  const FirstPosesSpec& spec;
};

// Result of a search.
struct FirstPoses {
  std::vector<Candidate> candidates;       // of all searched regions
  std::vector<PoseHypothesis> hypotheses;  // selected, highest score first
};

// Searches `cloud` until spec.poses poses have at least the score spec.confidence and are reachable
// (input.count_reachable), or until all of the foreground is searched. The result has also the less
// confident poses of the searched regions, since they are obstacles for a grasp. Up is the z axis
// of the known background, or else towards the camera. Adds times as CandidateFinder::Find() does,
// and "non_maximum_suppression", "regions" and "reach".
FirstPoses FindFirstPoses(const FirstPosesSearch& search, const OrganizedCloud& cloud,
                          const EstimatorInput& input, Rng& rng, StageSeconds& seconds);

}  // namespace pickbed::perception
