#pragma once

// From a cloud to refined pose candidates: points -> patches -> descriptors -> neighbours in the
// code book -> votes, which assessment.h takes on. The learned estimator and the training of its
// verifier share it, so that the verifier learns on exactly what it will judge.

#include <memory>
#include <vector>

#include "perception/candidate_source.h"
#include "perception/codebook.h"
#include "perception/estimate_trace.h"
#include "perception/neighbors.h"

namespace pickbed {

struct CandidateOptions : AssessmentOptions {
  int points = 600;      // patches of a frame, of all sizes together; parts differ in theirs
  int min_points = 450;  // of each size at least, unless `points` is less
  int neighbors = 8;     // votes of a patch
  int rounds = 1;        // later ones look where no candidate explains what is seen
  NeighborOptions index;
  void Visit(SettingsVisitor& v);
};

// For mode "hard": parts that others hide, at some three times the time.
CandidateOptions HardCandidates();

// What a part brings with it.
struct CandidatePart {
  std::shared_ptr<const ObjectModel> model;
  double side_m = 0;  // of its patches
  ObjectCodes codes;
};

class CandidateFinder : public CandidateSource {
 public:
  // Results are the same for any number of threads.
  CandidateFinder(std::vector<CandidatePart> parts, DescribePatches describe,
                  const CandidateOptions& options, int threads = 1);
  ~CandidateFinder() override;

  // Seconds are added under "patches", "network" and "neighbors", and those of CandidateAssessor. A
  // trace gets patches, votes and refinements.
  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds& seconds,
                              EstimateTrace* trace = nullptr) const override;

  const CandidateAssessor& assessor() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
