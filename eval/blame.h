#pragma once

// Charges a pick, and each part that was not found, to the one stage that lost it.
//
// A wrong belief is to blame before the grasp is: what the hand did at a wrong pose says nothing,
// unless physics broke. Of the belief's makers the last is to blame that had a right pose in hand:
// the final refiner, then the suppression, then the search. A belief without a right pose on its
// way names the wrong part where a part of another kind lies nearest, else its pose was wrong.

#include <vector>

#include "eval/matching.h"
#include "eval/metrics.h"
#include "eval/trial.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

// What a judge knows of a look.
struct LookTruth {
  const Scene& scene;  // before the pick
  const std::vector<MetricModel>& models;
  const Camera& camera;
};

// The loss of an executed pick; kNone when it succeeded. Another part that came in place of the one
// that was meant counts as kTookTwo where the belief was right.
Loss LossOf(const PickRecord& record, const PoseHypothesis& chosen, const LookTruth& truth);

// The loss of a look without a grasp. Without hypotheses: kNotVisible, or kNoProposal when some
// instance is in view. Where none of them is right their maker is to blame, as for the first;
// else kNoGrasp.
Loss LossWithoutGrasp(const PickRecord& record, const std::vector<PoseHypothesis>& hypotheses,
                      const LookTruth& truth);

// The same of a look at which record.target alone was to be picked: by the hypotheses `aims` that
// stand on it. Without any: why it was missed.
Loss LossWithoutGraspOnTarget(const PickRecord& record, const std::vector<int>& aims,
                              const std::vector<PoseHypothesis>& hypotheses,
                              const LookTruth& truth);

// Of each instance of the look why no hypothesis recalls it: kNone where one does; kNotVisible
// under kCountedVisibility; kRefinementWorse or kSuppressed where a right pose was in hand;
// kPoseWrong or kWrongPart where a hypothesis of its own or of another kind lies nearest to it;
// else kNoProposal.
std::vector<Loss> WhyMissed(const LookScore& look, const std::vector<PoseHypothesis>& hypotheses,
                            const LookTruth& truth);

}  // namespace pickbed
