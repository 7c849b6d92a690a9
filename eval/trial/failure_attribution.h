#pragma once

// Attributes a failed pick, and each instance that was not recalled, to one stage.
//
// A wrong estimate comes before the grasp: the result of a grasp at a wrong pose has no meaning,
// unless the physics failed. The estimate is attributed to the last stage that had a correct pose:
// final refinement, then non-maximum suppression, then the search. If no stage had one, the reason
// is kWrongObject if an instance of another object is nearest, else kPoseWrong.

#include <vector>

#include "eval/trial/instance_matcher.h"
#include "eval/trial/pose_matching.h"
#include "eval/trial/trial_records.h"

namespace pickbed::eval {

// The failure reason of an attempt; `truth` is from before the pick; kNone if the pick succeeded.
// - With an executed grasp: kDoublePick if another instance came although the pose was correct.
// - Without a grasp and without hypotheses: kNotVisible, or kNoProposal if an instance is visible.
// - Without a grasp: kNoGrasp if a hypothesis is correct, else the reason why the best one is
// wrong.
// - Without a grasp, but with a target: only the hypotheses that match the target (within
//   `match_diameters`) count. Without any, the reason why the target is not recalled.
// - Without a pose stage: the physical outcome; kNoGrasp or kNotVisible without a grasp.
FailureReason AttributeFailure(const AttemptRecord& record,
                               const std::vector<ScoredHypothesis>& hypotheses,
                               double match_diameters, const InstanceMatcher& truth);

// For each instance, why no hypothesis recalls it: kNone if one does; kNotVisible below
// kCountedVisibility; kRefinementWorse or kSuppressed if a correct pose existed before that stage;
// kPoseWrong or kWrongObject if a hypothesis of the same or of another object is nearest to it;
// else kNoProposal.
std::vector<FailureReason> MissReasons(const AttemptScore& score, const InstanceMatcher& truth);

}  // namespace pickbed::eval
