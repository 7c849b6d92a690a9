#pragma once

// The estimator that knows: true poses with chosen noise. An upper bound for any estimator, and
// with noise a measure of how exact poses must be. It needs the truth, so it is eval's own row
// joined to perception's table.

#include <string>
#include <vector>

#include "eval/virtual_cell.h"
#include "perception/pose_hypothesis.h"
#include "scenes/random.h"

namespace pickbed {

inline constexpr char kOracleName[] = "oracle";

// One hypothesis for each instance that is at least 10 % visible, highest score first; the score is
// the visible fraction. The position gets noise_mm on each axis, the orientation a turn by
// noise_deg about a random axis (both normal, sigma). `min_score` does not apply: the oracle
// reports all that a perfect estimator could.
std::vector<PoseHypothesis> OracleEstimate(const Scene& truth, const View& view,
                                           const Camera& camera, const EstimatorSpec& spec,
                                           Rng& rng);

struct EstimatorName {
  std::string name;
  std::string help;
};
// perception's estimators and the oracle.
std::vector<EstimatorName> EstimatorNames();

// Throws InputError with the nearest known name.
void RequireEstimator(const std::string& name);

}  // namespace pickbed
