#pragma once

// Trains the verifier of one part with the estimator's own front part: its candidates of piles that
// hold the part, right or wrong by the truth. Then its score is calibrated on what is left of them
// when the set is made consistent, as it is reported: logistic calibration (Platt 1999).

#include <functional>

#include "perception/candidates.h"
#include "perception/torch_verifier.h"
#include "scenes/labelled_view.h"

namespace pickbed {

struct VerifierTrainingOptions {
  uint64_t seed = 0;
  int piles = 24;
  int views_per_pile = 3;
  double calibration_share = 0.3;  // last share of the piles, for figure and calibration
  VerifierOptions verifier;
  void Visit(SettingsVisitor& v);
};

// What finds the candidates of the one part, given the piles that it will look at.
using MakeCandidateSource =
    std::function<std::unique_ptr<CandidateSource>(const std::vector<LabelledView>& piles)>;

// A part with what describes its patches.
struct VerifierPart {
  int object = 0;  // of the view source
  double side_m = 0;
  int descriptor_length = 0;
  DescribePatches describe;
  int entries = 24000;  // of its code book
  CandidateOptions candidates;
};

// Candidates by learned descriptors: a code book for the distances that the piles are seen from.
MakeCandidateSource DescriptorSource(LabelledViewSource& views, const VerifierPart& part,
                                     uint64_t seed);

// Of part `object` of the view source; the candidates of `make` are all of object 0.
// on_share(0..1) returns false to stop; what comes back is then unfinished. Throws InputError when
// all candidates are right or all wrong.
TrainedVerifier TrainPartVerifier(LabelledViewSource& views, int object,
                                  const MakeCandidateSource& make,
                                  const VerifierTrainingOptions& options,
                                  const std::function<bool(double share)>& on_share);

// A score that was reported and whether it was right.
struct ScoredPose {
  double logit = 0;
  bool right = false;
};
// Sets the calibration of a verifier that has none yet so that scores are shares of right poses.
// Drawn a little towards no change, so that few poses change little.
void Calibrate(const std::vector<ScoredPose>& poses, Verifier& verifier);

}  // namespace pickbed
