#pragma once

// Interface of pose proposal methods, with learned descriptors or point pairs. They pass their raw
// poses to a CandidateRefiner. A verifier is trained on the candidates of the source whose
// candidates it will score.

#include "perception/candidates/candidate_refinement.h"
#include "scenes/base/random.h"

namespace pickbed::perception {

// Proposes raw poses in addition to the votes of patches.
class PoseProposer {
 public:
  virtual ~PoseProposer() = default;

  // Returns raw poses by object index. Adds the time of each stage to `seconds`.
  virtual std::vector<std::vector<PoseVote>> Propose(const OrganizedCloud& cloud,
                                                     StageSeconds& seconds) const = 0;
};

// Finds the candidates of all objects in a cloud.
class CandidateSource {
 public:
  virtual ~CandidateSource() = default;

  // Returns the candidates of all objects; hypothesis.object is the object index. Adds the time of
  // each stage to `seconds`, and the intermediate results to `trace` if given.
  virtual std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds& seconds,
                                      EstimateTrace* trace = nullptr) const = 0;
  virtual const CandidateRefiner& candidate_refiner() const = 0;
};

}  // namespace pickbed::perception
