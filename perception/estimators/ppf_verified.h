#pragma once

// Point pair features with the second half of the learned estimator: OpenCV's raw poses, before any
// averaging and ICP of its own, go through the same assessment, a verifier that was trained on
// them, and the same final set. What is left to tell the two apart is who proposes the poses.

#include <filesystem>
#include <memory>

#include "perception/candidate_source.h"
#include "perception/estimators/ppf_matcher.h"
#include "perception/final_set.h"
#include "perception/polish.h"
#include "perception/pose_estimator.h"

namespace pickbed {

inline constexpr const char* kVerifiedMode = "verified";

struct VerifiedPpfOptions {
  PpfMatchOptions match{.window_diameters = 2};
  AssessmentOptions assessment;
  FinalSetOptions final_set;  // its least score is the setup's
  PolishOptions polish;
  VerifiedPpfOptions();  // assessment as thorough as the learned estimator's mode hard
};

// Seconds are added under "match", and those of CandidateAssessor. Draws no random numbers.
std::unique_ptr<CandidateSource> MakePpfCandidates(const ObjectSet& objects,
                                                   const VerifiedPpfOptions& options,
                                                   int threads = 1);
// Of the table: with the options by default.
std::unique_ptr<CandidateSource> MakePpfCandidates(const CandidateSetup& setup);

// The file of verifiers by spec.model, or assets/models/ppf.pt; empty where the mode needs none.
std::filesystem::path PpfModelFile(const EstimatorSpec& spec);

// Throws InputError as LoadVerifiers and TrainedParts do.
std::unique_ptr<PoseEstimator> MakeVerifiedPpfEstimator(const EstimatorSetup& setup,
                                                        const VerifiedPpfOptions& options);

}  // namespace pickbed
