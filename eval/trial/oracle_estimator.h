#pragma once

// The oracle estimator reports ground-truth poses with a chosen noise. It is an upper bound for any
// estimator; with noise it measures how accurate poses must be. It needs ground truth, so eval adds
// it to the estimators of perception.

#include <string>
#include <vector>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/instance_matcher.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/random.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

inline constexpr char kOracleName[] = "oracle";

// Returns the instances with the poses at which the image of this bin shows them. They differ from
// the true ones if the cell has errors of the intrinsics or the depth.
std::vector<TrueInstance> InstancesInImage(const SimulatedCell& cell, BinIndex bin_index,
                                           std::vector<TrueInstance> instances);

// Returns one hypothesis for each of `instances` that is at least 10 % visible, highest score
// first. The score is the visible fraction. The noise is normal: sigma noise_mm on each axis of the
// position, and a rotation with sigma noise_deg about a random axis. `min_score` does not apply,
// because the oracle reports everything that a perfect estimator could. The time is under
// "estimate".
EstimateResult OracleEstimate(const std::vector<TrueInstance>& instances, const EstimatorSpec& spec,
                              Rng& rng);

struct EstimatorName {
  std::string name;
  std::string help;
};
// Returns the estimators of perception and the oracle.
std::vector<EstimatorName> EstimatorNames();

// Throws InputError with the nearest known name if `name` is not in EstimatorNames().
void RequireEstimator(const std::string& name);

}  // namespace pickbed::eval
