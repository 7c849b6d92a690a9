#pragma once

// Point pair features with the later stages of the learned estimators. OpenCV's raw poses, without
// its averaging and ICP, pass through candidate refinement, a verifier trained on them, and pose
// selection. The estimators then differ only in how raw poses are proposed.

#include <memory>

#include "perception/candidates/candidate_source.h"
#include "perception/candidates/pose_selection.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/estimators/ppf_matcher.h"
#include "perception/icp/final_refinement.h"

namespace pickbed::perception {

inline constexpr const char* kVerifiedMode = "verified";

struct VerifiedPpfOptions {
  PpfMatchOptions match{.window_diameters = 2};
  CandidateRefinementOptions refinement;
  PoseSelectionOptions pose_selection;  // min_score is replaced by spec.min_score of the setup
  VerifiedPpfOptions();                 // refinement as in AccurateCandidates()
};

// Makes the candidate source. Times are added under "match" and the names of CandidateRefiner. It
// draws no random numbers.
std::unique_ptr<CandidateSource> MakePpfCandidates(const ObjectSet& objects,
                                                   const VerifiedPpfOptions& options,
                                                   int threads = 1);

// Entry of EstimatorTable(). Its candidates have default options. The model file has the verifiers
// and is ppf.net by default; it is empty for modes without verifier.
std::unique_ptr<EstimatorTraining> MakePpfTraining();

// Makes the estimator. Throws InputError as LoadVerifiers and TrainedObjects do.
std::unique_ptr<PoseEstimator> MakeVerifiedPpfEstimator(const EstimatorSetup& setup,
                                                        const VerifiedPpfOptions& options);

}  // namespace pickbed::perception
