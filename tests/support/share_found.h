#pragma once

// How many parts that lie free an estimator finds.

#include <algorithm>

#include "perception/pose_estimator.h"
#include "perception/votes.h"
#include "tests/support/ray_cast_views.h"

namespace pickbed {

// Share of the parts of four piles of object 0, not those of any training, to which a reported pose
// is within a tenth of the diameter.
inline double ShareFound(PoseEstimator& estimator, RayCastViews& views) {
  const PoseDistance distance(*views.objects()[0]);
  int found = 0, parts = 0;
  for (uint64_t seed = 5000; seed < 5004; ++seed) {
    const LabelledView view = views.Pile({seed, 1}).front();
    Rng rng(1);
    const EstimateResult result = estimator.Estimate({view.frame, OutOfSightBin()}, rng);
    for (const LabelledInstance& instance : view.instances) {
      ++parts;
      found += std::ranges::any_of(result.hypotheses, [&](const PoseHypothesis& hypothesis) {
        return distance(hypothesis.X_CO, instance.X_CO) < 0.1;
      });
    }
  }
  return static_cast<double>(found) / parts;
}

}  // namespace pickbed
