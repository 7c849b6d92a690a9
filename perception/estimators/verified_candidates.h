#pragma once

// An estimator of any source of candidates: cloud -> candidates -> final set by the parts'
// verifiers -> final refiner. What tells two of them apart is who proposes the poses.

#include <memory>
#include <string>
#include <vector>

#include "perception/candidate_source.h"
#include "perception/final_set.h"
#include "perception/polish.h"
#include "perception/pose_estimator.h"
#include "perception/torch_verifier_file.h"

namespace pickbed {

struct VerifiedSetup {
  std::unique_ptr<CandidateSource> source;
  std::vector<Verifier> verifiers;  // of each part of the source
  FinalSetOptions final_set;
  PolishOptions polish;
  std::string refiner;
  int threads = 1;
};

std::unique_ptr<PoseEstimator> MakeVerifiedEstimator(VerifiedSetup setup);

// The verifiers of these parts in the file of verifiers, in their order. Throws InputError as
// LoadVerifiers and TrainedParts do.
std::vector<Verifier> VerifiersOf(const VerifierFile& trained, const ObjectSet& objects,
                                  const std::filesystem::path& file);

}  // namespace pickbed
