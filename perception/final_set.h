#pragma once

// From refined candidates to what an estimator reports: scored by the verifier of their part, equal
// poses merged, and no two that claim the same pixels or lie in each other. Shared by the estimator
// and by the calibration of its scores.

#include <span>
#include <vector>

#include "perception/assessment.h"
#include "perception/suppress.h"
#include "perception/votes.h"

namespace pickbed {

struct FinalSetOptions {
  double min_score = 0.5;        // below it a pose is not reported
  double merge_diameters = 0.1;  // poses of a part within it are one
  CandidateMode mode = CandidateMode::kHard;
  SuppressOptions suppress;
};

// What the verifier says of a candidate, less what the part's print speaks against it. The print is
// looked at from a score of `least` on; a lower one stands as it is.
double CandidateScore(const OrganizedCloud& cloud, const ModelPoints& model,
                      const Verifier& verifier, const Candidate& candidate, CandidateMode mode,
                      double least = 0);

// Highest score first. `models`, `distances`, `verifiers` and, where not empty, `instances`
// (EstimatorInput) by object index.
std::vector<PoseHypothesis> FinalSet(const OrganizedCloud& cloud,
                                     const std::vector<ModelPoints>& models,
                                     const std::vector<PoseDistance>& distances,
                                     std::span<const Verifier> verifiers,
                                     const std::vector<Candidate>& candidates,
                                     const FinalSetOptions& options,
                                     std::span<const int> instances = {});

}  // namespace pickbed
