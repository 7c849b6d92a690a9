#pragma once

// The oracle estimator reports ground-truth poses with a chosen noise. It is an upper bound for any
// estimator; with noise it measures how accurate poses must be. It needs ground truth, so eval adds
// it to the estimators of perception.

#include <string>
#include <vector>

#include "eval/trial/estimator_runner.h"
#include "eval/trial/simulated_cell.h"
#include "perception/pose_hypothesis.h"
#include "scenes/base/random.h"

namespace pickbed::eval {

inline constexpr char kOracleName[] = "oracle";

// Returns one hypothesis for each instance that is at least 10 % visible, highest score first. The
// score is the visible fraction. The noise is normal: sigma noise_mm on each axis of the position,
// and a rotation with sigma noise_deg about a random axis. `min_score` does not apply, because the
// oracle reports everything that a perfect estimator could.
std::vector<PoseHypothesis> OracleEstimate(const Scene& truth, const Observation& view,
                                           const Camera& camera, const EstimatorSpec& spec,
                                           Rng& rng);

// Returns the poses of the estimator for this observation, or noisy ground truth if the scenario
// names the oracle. Only the oracle reads `scene`.
EstimateResult EstimateWithOracle(EstimatorRunner& estimator, const Scene& scene,
                                  const Observation& view, Rng& rng,
                                  EstimateTrace* trace = nullptr);

struct EstimatorName {
  std::string name;
  std::string help;
};
// Returns the estimators of perception and the oracle.
std::vector<EstimatorName> EstimatorNames();

// Throws InputError with the nearest known name if `name` is not in EstimatorNames().
void RequireEstimator(const std::string& name);

}  // namespace pickbed::eval
