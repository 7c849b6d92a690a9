#pragma once

// From a cloud to refined pose candidates: points -> patches -> votes, which assessment.h takes on.
// A patch votes for the poses of its neighbours in the code book, or for the pose that a network
// regresses from it. The learned estimators and the training of their verifiers share it, so that a
// verifier learns on exactly what it will judge.

#include <memory>
#include <vector>

#include "perception/candidate_source.h"
#include "perception/estimate_trace.h"
#include "perception/neighbors.h"
#include "perception/patch_voter.h"
#include "perception/vote_modes.h"

namespace pickbed {

struct CandidateOptions : AssessmentOptions {
  int points = 600;      // patches of a frame, of all sizes together; parts differ in theirs
  int min_points = 450;  // of each size at least, unless `points` is less
  int neighbors = 8;     // votes of a patch
  int rounds = 1;        // later ones look where no candidate explains what is seen
  // What is assessed: each vote of a neighbour (neighbors), the modes of these votes (modes, see
  // vote_modes.h), what the network regresses (regressed), or neighbours' votes and what is
  // regressed together (both).
  std::string votes = "neighbors";
  double least_share =
      0.2;  // of regressed votes: the patch shows the part, as the network believes
  ModeOptions modes;
  NeighborOptions index;
  void Visit(SettingsVisitor& v);
};

// For mode "hard": parts that others hide, at some three times the time.
CandidateOptions HardCandidates();

// What a part brings with it.
struct CandidatePart {
  std::shared_ptr<const ObjectModel> model;
  double side_m = 0;  // of its patches
  ObjectCodes codes;  // empty where votes are regressed
  int trained = 0;    // which part it is to the network that regresses
};

class CandidateFinder : public CandidateSource {
 public:
  // Results are the same for any number of threads. Throws InputError where votes are to be
  // regressed and the network does not.
  CandidateFinder(std::vector<CandidatePart> parts, PatchVoter voter,
                  const CandidateOptions& options, int threads = 1);
  ~CandidateFinder() override;

  // Seconds are added under "patches", "network" and "neighbors", and those of CandidateAssessor. A
  // trace gets patches, votes and refinements. Throws InputError as RequireChannels() does.
  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds& seconds,
                              EstimateTrace* trace = nullptr) const override;

  const CandidateAssessor& assessor() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
