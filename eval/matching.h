#pragma once

// Hypotheses of one look against the truth.

#include <vector>

#include "eval/metrics.h"
#include "eval/trial.h"

namespace pickbed {

struct LookScore {
  std::vector<HypothesisScore> hypotheses;  // in the order given
  std::vector<InstanceRecord> instances;    // in the order of the scene
  std::vector<int> taken;                   // by hypothesis: index of the instance that it recalls,
                                            // -1 = none
  std::vector<int> nearest_object;          // by hypothesis: kind of the part whose mean vertex
                                            // is nearest, of whatever kind
};

// Each hypothesis is compared with the nearest instance (MSSD) of its own object; its `instance` is
// -1 and its errors are infinite when the scene holds none. An instance is recalled when a
// hypothesis is correct for it: hypotheses take instances in order of score, each the nearest that
// is still free, so that no hypothesis counts twice.
LookScore ScoreLook(const Scene& truth, const std::vector<double>& visible_fractions,
                    const std::vector<MetricModel>& models, const Camera& camera,
                    const std::vector<PoseHypothesis>& hypotheses);

// MSSD below this share of the diameter is a correct pose (Drost et al. 2017, BOP).
inline constexpr double kCorrectDiameters = 0.1;
// A pose stands on a part below this share of the diameter, wrong as it may be.
inline constexpr double kStandsOnDiameters = 0.5;

}  // namespace pickbed
