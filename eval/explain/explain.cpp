#include "eval/explain/explain.h"

#include <fmt/format.h>

#include "eval/trial/estimator_runner.h"
#include "eval/trial/oracle_estimator.h"
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

std::string ExplainTrial(const ScenarioSpec& spec, const ObjectSet& objects,
                         const std::string& title, int trial, const std::filesystem::path& folder,
                         const std::function<void(std::string_view, double)>& on_progress) {
  RequireExplains(spec.estimator.name);
  SimulatedCell cell(spec, objects);
  EstimatorRunner runner(cell, spec, 1, on_progress);
  const Scene scene = cell.MakeScene(BinIndex(trial)).scene;
  const Observation view = cell.Capture(scene, BinIndex(trial), 0);
  std::vector<TruePart> truth;
  const Pose X_CW = cell.camera().X_CW();
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    truth.push_back({posed.object, X_CW * posed.X_WO, view.visible_fractions[i]});
  }
  EstimateTrace trace;
  Rng rng = Rng::Derive(spec.seed, trial, "estimate/0");
  const EstimateResult result = EstimateWithOracle(runner, scene, view, rng, &trace);
  const auto views = CellViews(cell, cell.objects());  // the trace has the cell's object indices
  return WriteExplanation({title, view.frame, cell.objects(), trace, result.hypotheses,
                           std::move(truth), *views, runner.working_distance_m()},
                          folder);
}

}  // namespace pickbed::eval
