#pragma once

// Trains the verifier of one part with the estimator's own front part: its candidates of piles that
// hold the part, right or wrong by the truth, in each mode that it will judge. Then its score is
// calibrated on what is left of a mode's when the set is made consistent, as it is reported:
// logistic calibration (Platt 1999).

#include <functional>
#include <span>
#include <vector>

#include "perception/candidates.h"
#include "perception/final_set.h"
#include "perception/labelled_patches.h"
#include "perception/torch_verifier.h"
#include "scenes/labelled_view.h"

namespace pickbed {

struct VerifierTrainingOptions {
  uint64_t seed = 0;
  int piles = 24;
  int views_per_pile = 3;
  double calibration_share = 0.3;  // last share of the piles, for figure and calibration
  VerifierOptions verifier;
  // Of learned descriptors alone:
  int entries = 24000;                           // of the part's code book
  std::vector<CandidateOptions> candidates{{}};  // of each mode
  void Visit(SettingsVisitor& v);                // of all but these two
};

// A part with what describes its patches.
struct VerifierPart {
  int object = 0;  // of the view source
  double side_m = 0;
  int descriptor_length = 0;
  PatchVoter voter;
};

// What a part's verifier learns from, as far as it needs no network.
struct VerifierLesson {
  std::vector<LabelledView> piles;  // views of piles that hold the part
  LabelledPatches codes;            // of the part's code book
};

// on_share(0..1) returns false to stop; what comes back is then unfinished. Throws InputError when
// no pile shows the part.
VerifierLesson MakeVerifierLesson(LabelledViewSource& views, int object, const PatchForm& form,
                                  const VerifierTrainingOptions& options,
                                  const std::function<bool(double share)>& on_share);

// Views of piles that hold the part, with colour only where asked for; fewer when on_share(0..1)
// returns false.
std::vector<LabelledView> VerifierPiles(LabelledViewSource& views, int object, bool color,
                                        const VerifierTrainingOptions& options,
                                        const std::function<bool(double share)>& on_share);

// Of part `object` of the view source; the candidates of the sources, one a mode in the order of
// CandidateMode that look for the same part, are all of object 0. Modes without a source are
// calibrated as the first is.
// on_share(0..1) returns false to stop; what comes back is then unfinished. Throws InputError when
// all candidates are right or all wrong.
TrainedVerifier TrainPartVerifier(const std::vector<LabelledView>& piles, int object,
                                  std::span<const CandidateSource* const> sources,
                                  const VerifierTrainingOptions& options,
                                  const std::function<bool(double share)>& on_share);

// By the candidates of learned descriptors.
TrainedVerifier TrainPartVerifier(const VerifierLesson& lesson,
                                  const std::shared_ptr<const ObjectModel>& model,
                                  const VerifierPart& part, const VerifierTrainingOptions& options,
                                  const std::function<bool(double share)>& on_share);

// A score that was reported and whether it was right.
struct ScoredPose {
  double logit = 0;
  bool right = false;
};
// What makes scores of a verifier that is not calibrated shares of right poses. Drawn a little
// towards no change, so that few poses change little.
Calibration Calibrate(const std::vector<ScoredPose>& poses);

}  // namespace pickbed
