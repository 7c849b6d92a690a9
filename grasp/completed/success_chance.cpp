#include "grasp/completed/success_chance.h"

#include <algorithm>
#include <cmath>

#include "scenes/base/math.h"

namespace pickbed::grasp {

double SuccessChance::Of(const GraspMeasures& grasp) const {
  constexpr double kMinScore = 1e-6;  // the logarithm of 0 is not finite
  const double log_score = std::log(std::max(grasp.score, kMinScore));
  if (grasp.is_suction) return Logistic(suction + suction_score * log_score);
  double log_odds = observed + observed_score * log_score;
  if (grasp.surface == GraspedSurface::kCompleted) {
    log_odds = completed - thin * std::max(0.0, 1 - grasp.width_m / full_width_m) -
               hidden * std::min(1.0, grasp.hidden_m / full_hidden_m);
  }
  log_odds -= covered * grasp.covered;
  log_odds -= center_offset_per_m * grasp.center_offset_m;
  return Logistic(log_odds);
}

double SuccessChance::AfterRehearsal(double chance, double hit_share, double lost_share) const {
  return LessLikely(chance, rehearsal_hit * hit_share + rehearsal_lost * lost_share);
}

void SuccessChance::Visit(SettingsVisitor& v) {
  const Range log_odds{-20, 20}, loss{0, 20}, per_m{0, 1000}, length{0.0001, 1};
  v.Real("suction", suction, log_odds, "log odds of success of a suction cup with score 1");
  v.Real("suction_score", suction_score, loss,
         "change of these log odds with the natural logarithm of the score");
  v.Real("observed", observed, log_odds,
         "log odds of success of a jaw on the observed surface with score 1");
  v.Real("observed_score", observed_score, loss,
         "change of these log odds with the natural logarithm of the score");
  v.Real("completed", completed, log_odds, "log odds of success of a jaw on a completed shape");
  v.Real("thin", thin, loss, "loss of log odds of a completed shape without thickness");
  v.Real("full_width_m", full_width_m, length, "thickness from which there is no loss, m");
  v.Real("hidden", hidden, loss, "loss of log odds of fingers deep in hidden space");
  v.Real("full_hidden_m", full_hidden_m, length,
         "mean depth of the fingers in hidden space at which the loss is full, m");
  v.Real("covered", covered, loss, "loss of log odds of a segment that others cover all around");
  v.Real("center_offset_per_m", center_offset_per_m, per_m,
         "loss of log odds for each metre from the closing line to the center of the segment");
  v.Real("rehearsal_hit", rehearsal_hit, loss,
         "loss of log odds if the hand hits the object in all rehearsals that count");
  v.Real("rehearsal_lost", rehearsal_lost, loss,
         "loss of log odds if the hand loses the object in all rehearsals that count");
}

}  // namespace pickbed::grasp
