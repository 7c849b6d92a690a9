#pragma once

// Recall of an estimator on instances without occlusion.

#include <algorithm>

#include "perception/estimators/pose_estimator.h"
#include "perception/voting/pose_clustering.h"
#include "tests/support/ray_cast_views.h"

namespace pickbed::tests {

// Returns the fraction of instances of object 0, in four scenes that no training uses, with a
// reported pose within a tenth of the diameter.
inline double ShareFound(PoseEstimator& estimator, RayCastViews& views) {
  const PoseDistance distance(*views.objects()[0]);
  int found = 0, instances = 0;
  for (uint64_t seed = 5000; seed < 5004; ++seed) {
    const LabelledView view = views.ClutterScene({seed, 1}).front();
    Rng rng(1);
    const EstimateResult result = estimator.Estimate({view.frame, OutOfSightBin()}, rng);
    for (const LabelledInstance& instance : view.instances) {
      ++instances;
      found += std::ranges::any_of(result.hypotheses, [&](const PoseHypothesis& hypothesis) {
        return distance(hypothesis.X_CO, instance.X_CO) < 0.1;
      });
    }
  }
  return static_cast<double>(found) / instances;
}

}  // namespace pickbed::tests
