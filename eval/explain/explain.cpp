#include "eval/explain/explain.h"

#include <fmt/format.h>

#include "eval/draw/bin_view.h"
#include "eval/trial/estimator_runner.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/error.h"

namespace pickbed::eval {

void RequireExplains(const std::string& estimator) {
  std::string able;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (!row.explains) continue;
    if (estimator == row.name) return;
    able += fmt::format("{}{}", able.empty() ? "" : ", ", row.name);
  }
  throw InputError(fmt::format(
      "estimator '{}' does not report the stages of its estimate; name one that does: {}",
      estimator, able));
}

ExplanationPage ExplainTrial(const ScenarioSpec& spec, const ObjectSet& objects,
                             const std::string& title, BinIndex bin_index,
                             const std::filesystem::path& folder,
                             const std::function<void(std::string_view, double)>& on_progress) {
  RequireExplains(spec.estimator.name);
  SimulatedCell cell(spec, objects);
  EstimatorRunner runner(cell, spec, 1, on_progress);
  const Scene scene = cell.MakeScene(bin_index).scene;
  const Observation view = cell.Capture(scene, bin_index, 0);
  std::vector<TrueInstance> truth =
      InstancesOf(scene, view.visible_fractions, cell.camera().X_CW());
  EstimateTrace trace;
  Rng rng = Rng::Derive(spec.seed, bin_index, "estimate/0");
  const EstimateResult result = runner.Estimate(view.frame, view.calibration, rng, &trace, {},
                                                /*is_first=*/true);
  const auto views = CellViews(cell, cell.objects());  // the trace has the cell's object indices
  return WriteExplanation(
      {title, TrialImageName(bin_index), view.frame, cell.objects(), trace, result.hypotheses,
       std::move(truth), *views, WorkingDistance_m(cell), BinRegion(cell.camera(), cell.bin())},
      folder);
}

}  // namespace pickbed::eval
