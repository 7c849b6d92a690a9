#pragma once

// From a cloud to pose candidates: sample points, cut patches, cast votes, refine (see
// candidate_refinement.h). A patch votes for the poses of its nearest codebook entries, or for the
// pose that a network regresses. The learned estimators and the training of their verifiers share
// it, so that a verifier is trained on the same candidates that it will score.

#include <memory>
#include <vector>

#include "perception/candidates/candidate_source.h"
#include "perception/candidates/estimate_trace.h"
#include "perception/features/codebook.h"
#include "perception/features/neighbors.h"
#include "perception/voting/vote_modes.h"

namespace pickbed::perception {

// Options of pose voting and candidate refinement.
struct CandidateOptions : CandidateRefinementOptions {
  int points = 600;      // patches per frame, all patch sides together
  int min_points = 450;  // minimum number per patch side, but not more than `points`
  int neighbors = 8;     // codebook votes per patch
  // Later rounds sample only the pixels that no candidate explains. There are at least
  // `crowded_rounds` if the background is known and shows clearly more than usual_instances.
  int rounds = 1;
  int crowded_rounds = 2;
  double later_density = 4;  // factor of the patches per pixel in later rounds
  // Raw poses: codebook votes ("neighbors"), modes of these votes ("modes", see vote_modes.h),
  // poses regressed by the network ("regressed"), or codebook votes and regressed poses ("both").
  std::string votes = "neighbors";
  // Minimum regressed probability that a patch shows the object, for its vote to count.
  double min_share = 0.2;
  ModeOptions modes;
  NeighborOptions index;
  void Visit(SettingsVisitor& v);
};

// Options of the accurate mode: finds more occluded instances in two to three times the time.
CandidateOptions AccurateCandidates();

// An object with its patch size and codebook.
struct CandidateObject {
  std::shared_ptr<const ObjectModel> model;
  double side_m = 0;  // patch side
  ObjectCodes codes;  // empty if poses are only regressed
  int trained = 0;    // index of the object in the outputs of the regressing network
};

// Finds candidates with votes of local patches.
class CandidateFinder : public CandidateSource {
 public:
  // - proposer: its poses become candidates too, in Find(); null = none
  // Results do not depend on the number of threads. Throws InputError if the options ask for
  // regressed poses and the network regresses none.
  CandidateFinder(std::vector<CandidateObject> objects, PatchVoter voter,
                  const CandidateOptions& options, int threads = 1,
                  std::unique_ptr<PoseProposer> proposer = nullptr);
  ~CandidateFinder() override;

  // Adds times under "patches", "network", "neighbors", "modes" and the names of CandidateRefiner.
  // The trace gets patches, votes and refinements. Throws InputError as RequireChannels() does.
  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds& seconds,
                              EstimateTrace* trace = nullptr) const override;

  // Finds the candidates that the patches in `pixels` vote for, like Find(), with the density of
  // patches of the whole foreground. It does not compare the candidates with each other; call
  // candidate_refiner().Compare().
  std::vector<Candidate> FindIn(const OrganizedCloud& cloud, const std::vector<int>& pixels,
                                Rng& rng, StageSeconds& seconds,
                                EstimateTrace* trace = nullptr) const;

  const CandidateRefiner& candidate_refiner() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::perception
