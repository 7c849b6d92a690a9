#pragma once

// Estimator with any candidate source: cloud, candidates, pose selection with the verifiers, final
// refinement. Two such estimators differ only in their candidate source.

#include <memory>
#include <string>
#include <vector>

#include "perception/candidates/candidate_source.h"
#include "perception/candidates/pose_selection.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/icp/final_refinement.h"
#include "perception/networks/verifier_file.h"

namespace pickbed::perception {

// Inputs for making the estimator.
struct VerifiedSetup {
  std::unique_ptr<CandidateSource> source;
  std::vector<Verifier> verifiers;  // one per object of the source
  PoseSelectionOptions pose_selection;
  std::string refiner = "none";  // a row of RefinerTable()
  int threads = 1;
  int binning = 1;  // see SearchBinning()
};

// Makes the estimator; `setup.verifiers` must have one entry per object of the source.
std::unique_ptr<PoseEstimator> MakeVerifiedEstimator(VerifiedSetup setup);

// Returns the verifiers of these objects, in their order, from the loaded content of `file`. Throws
// InputError as TrainedObjects does.
std::vector<Verifier> VerifiersOf(const VerifierFile& trained, const ObjectSet& objects,
                                  const std::filesystem::path& file);

}  // namespace pickbed::perception
