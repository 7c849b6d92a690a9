#pragma once

// Estimated chance that a grasp of an unknown object succeeds.
//
// Planners rank their own grasps by scores that mean different things. A logistic function of the
// score and of a few measures of the grasp makes the grasps of different planners comparable. Its
// coefficients were fitted to grasps that were executed in bins of unknown objects, see
// docs/pages/guides/chance_of_success.md.

#include "grasp/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::grasp {

// Surface on which a grasp was planned.
enum class GraspedSurface { kCompleted, kObserved };

// Measures of a planned grasp.
struct GraspMeasures {
  GraspedSurface surface = GraspedSurface::kCompleted;
  bool is_suction = false;
  double score = 1;     // by its planner, 0..1; not used for jaws on completed shapes
  double width_m = 0;   // distance between the two contacts of a jaw
  double hidden_m = 0;  // mean depth of the fingers in space that the image does not show
  double covered = 0;   // share of the contour of the segment that nearer surfaces border, 0..1
  double center_offset_m = 0;  // CenterOffset_m() of the segment
};

// Coefficients of the log odds of success.
struct SuccessChance {
  double suction = 1.5;          // of a suction cup with score 1
  double suction_score = 1;      // for each unit of the natural logarithm of its score
  double observed = 2.95;        // of a jaw on the observed surface with score 1
  double observed_score = 0.86;  // for each unit of the natural logarithm of its score
  double completed = 2.71;       // of a jaw on a completed shape
  double thin = 4.0;            // loss of a completed shape without thickness, which may be thicker
  double full_width_m = 0.012;  // thickness from which there is no loss
  double hidden = 0.85;         // loss of fingers that enter hidden space by full_hidden_m or more
  double full_hidden_m = 0.01;
  // Losses of all jaws.
  double covered = 3.57;            // of a segment that others cover all around
  double center_offset_per_m = 31;  // for each metre of GraspMeasures::center_offset_m
  // Losses of a jaw that hits or loses the object in all rehearsals that count
  // (grasp/completed/rehearsal.h).
  double rehearsal_hit = 3.5;
  double rehearsal_lost = 1.2;

  // Returns the chance of success, 0..1.
  double Of(const GraspMeasures& grasp) const;
  // Returns `chance` after rehearsals. In a share of them the hand hits the object, in another
  // share it loses it, both 0..1. The result is never above `chance`.
  double AfterRehearsal(double chance, double hit_share, double lost_share) const;
  void Visit(SettingsVisitor& v);
};

}  // namespace pickbed::grasp
