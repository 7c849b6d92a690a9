#pragma once

// Whatever proposes poses and hands them to a CandidateAssessor: learned descriptors or point
// pairs. A verifier is trained on the candidates of the source that it will judge.

#include "perception/assessment.h"
#include "scenes/random.h"

namespace pickbed {

class CandidateSource {
 public:
  virtual ~CandidateSource() = default;

  // Candidates of all parts; hypothesis.object is the index of the part. Adds seconds by stage.
  virtual std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng,
                                      StageSeconds& seconds) const = 0;
  virtual const CandidateAssessor& assessor() const = 0;
};

}  // namespace pickbed
