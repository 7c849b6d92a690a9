#include "eval/trial/oracle_estimator.h"

#include <algorithm>
#include <numbers>

#include "perception/estimators/pose_estimator.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

Pose WithNoise(const Pose& X_CO, const EstimatorSpec& spec, Rng& rng) {
  Pose noisy = X_CO;
  const double sigma_m = spec.noise_mm * 1e-3;
  for (int axis = 0; axis < 3; ++axis) noisy.translation()[axis] += sigma_m * rng.Normal();
  const double angle_rad = spec.noise_deg * std::numbers::pi / 180 * rng.Normal();
  const Eigen::Vector3d rotation_axis = rng.UnitVector();
  noisy.linear() = Eigen::AngleAxisd(angle_rad, rotation_axis).toRotationMatrix() * X_CO.linear();
  return noisy;
}

}  // namespace

std::vector<PoseHypothesis> OracleEstimate(const Scene& truth, const Observation& view,
                                           const Camera& camera, const EstimatorSpec& spec,
                                           Rng& rng) {
  const Pose& X_CW = camera.X_CW();
  std::vector<PoseHypothesis> hypotheses;
  for (size_t i = 0; i < truth.objects.size(); ++i) {
    const double visible = view.visible_fractions[i];
    if (visible < kCountedVisibility) continue;
    PoseHypothesis hypothesis;
    hypothesis.object = truth.objects[i].object;
    hypothesis.X_CO = WithNoise(X_CW * truth.objects[i].X_WO, spec, rng);
    hypothesis.score = visible;
    hypothesis.fit.inlier_share = visible;
    hypothesis.fit.hidden_share = 1 - visible;
    hypotheses.push_back(hypothesis);
  }
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  return hypotheses;
}

EstimateResult EstimateWithOracle(EstimatorRunner& estimator, const Scene& scene,
                                  const Observation& view, Rng& rng, EstimateTrace* trace) {
  if (!estimator.is_oracle()) return estimator.Estimate(view.frame, rng, trace);
  EstimateResult result;
  {
    const StageTimer timer(result.seconds, "estimate");
    result.hypotheses =
        OracleEstimate(scene, view, estimator.cell().camera(), estimator.spec(), rng);
  }
  return result;
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
