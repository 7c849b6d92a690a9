#include "eval/trial/oracle_estimator.h"

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

Pose WithNoise(const Pose& X_CO, const EstimatorSpec& spec, Rng& rng) {
  Pose noisy = X_CO;
  const double sigma_m = spec.noise_mm * 1e-3;
  for (int axis = 0; axis < 3; ++axis) noisy.translation()[axis] += sigma_m * rng.Normal();
  const double angle_rad = Radians(spec.noise_deg) * rng.Normal();
  const Eigen::Vector3d rotation_axis = rng.UnitVector();
  noisy.linear() = Eigen::AngleAxisd(angle_rad, rotation_axis).toRotationMatrix() * X_CO.linear();
  return noisy;
}

}  // namespace

std::vector<TrueInstance> InstancesInImage(const SimulatedCell& cell, BinIndex bin_index,
                                           std::vector<TrueInstance> instances) {
  const BinErrors errors = cell.ErrorsOf(bin_index);
  const Camera calibrated = CalibrationOf(cell.camera(), errors).camera;
  for (TrueInstance& instance : instances) {
    const Eigen::Vector3d& com_O = cell.objects()[instance.object]->mass.com_O;
    instance.X_CO =
        PoseInImage(instance.X_CO, com_O, cell.camera().intrinsics, calibrated.intrinsics, errors);
  }
  return instances;
}

EstimateResult OracleEstimate(const std::vector<TrueInstance>& instances, const EstimatorSpec& spec,
                              Rng& rng) {
  StageSeconds seconds;
  std::vector<PoseHypothesis> hypotheses;
  {
    const StageTimer timer(seconds, "estimate");
    for (const TrueInstance& instance : instances) {
      const double visible = instance.visible_fraction;
      if (visible < kCountedVisibility) continue;
      PoseHypothesis& hypothesis = hypotheses.emplace_back();
      hypothesis.object = instance.object;
      hypothesis.X_CO = WithNoise(instance.X_CO, spec, rng);
      hypothesis.score = visible;
      hypothesis.fit.inlier_share = visible;
      hypothesis.fit.hidden_share = 1 - visible;
    }
    std::stable_sort(hypotheses.begin(), hypotheses.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
  }
  return {std::move(hypotheses), std::move(seconds)};
}

std::vector<EstimatorName> EstimatorNames() {
  std::vector<EstimatorName> names;
  for (const EstimatorRow& row : EstimatorTable()) names.push_back({row.name, row.help});
  names.push_back(
      {kOracleName, "true poses with noise_mm and noise_deg added: an upper bound for estimators"});
  return names;
}

void RequireEstimator(const std::string& name) {
  std::vector<std::string> known;
  for (const EstimatorName& row : EstimatorNames()) known.push_back(row.name);
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  throw InputError(UnknownNameMessage("estimator", name, known));
}

}  // namespace pickbed::eval
