#include <fmt/format.h>

#include <algorithm>

#include "eval/trial/attempt.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {
namespace {

// The certificate of the start scene, with the worst values of all scenes of the series.
SceneCertificate WorstOf(const MadeSeries& made) {
  SceneCertificate worst = made.start.certificate;
  for (const OccludedScene& scene : made.series.scenes) {
    const SceneCertificate& one = scene.certificate;
    worst.deepest_penetration_m = std::max(worst.deepest_penetration_m, one.deepest_penetration_m);
    worst.wake_movement_m = std::max(worst.wake_movement_m, one.wake_movement_m);
    worst.wake_movement_diameters =
        std::max(worst.wake_movement_diameters, one.wake_movement_diameters);
    worst.max_speed_mps = std::max(worst.max_speed_mps, one.max_speed_mps);
    worst.max_spin_radps = std::max(worst.max_spin_radps, one.max_spin_radps);
  }
  return worst;
}

void CountTarget(const Scene& scene, const std::vector<double>& sizes, TrialResult& result) {
  const AttemptRecord& pick = result.attempts.back();
  const auto target =
      std::find_if(scene.objects.begin(), scene.objects.end(),
                   [&](const PosedObject& posed) { return posed.instance == pick.target; });
  InstanceOutcome& instance_outcome = result.outcomes.emplace_back();
  instance_outcome.instance = pick.target;
  instance_outcome.object = target->object;
  instance_outcome.deviation = target->deviation;
  instance_outcome.size_deviation = sizes[target->object];
  instance_outcome.picked = pick.failure == FailureReason::kNone;
  instance_outcome.failure = pick.failure;
  instance_outcome.attempt = pick.attempt;
  ++result.instances_dropped;
  result.instances_cleared += instance_outcome.picked;
}

}  // namespace

TrialResult RunOcclusionTrial(TrialSetup& setup, BinIndex bin_index, TrialObserver* observer) {
  LiveTrial trial;
  trial.bin_index = bin_index;
  trial.observer = observer;
  TrialResult result;
  result.trial = result.bin_index = bin_index;
  result.errors = setup.cell.ErrorsOf(bin_index);
  trial.objects = setup.cell.TrueObjects(bin_index);
  const std::vector<double> sizes = setup.cell.SizesOf(bin_index);
  MadeSeries made;
  {
    const StageTimer timer(trial.seconds, "drop");
    made = setup.cell.MakeSeries(bin_index);
  }
  result.certificate = WorstOf(made);
  result.refused = made.start.refused;
  result.bands = made.bands;
  for (const OccludedScene& occluded : made.series.scenes) {
    trial.scene = occluded.scene;
    trial.failed.Clear();
    const int attempt = static_cast<int>(result.attempts.size());
    result.attempts.push_back(
        RunAttempt(setup, {attempt, made.series.target, occluded.band}, trial));
    CountTarget(occluded.scene, sizes, result);
    if (!setup.on_progress) continue;
    const double share = static_cast<double>(result.attempts.size()) / made.series.scenes.size();
    setup.on_progress(fmt::format("trial {}", bin_index), share);
  }
  result.seconds = std::move(trial.seconds);
  return result;
}

}  // namespace pickbed::eval
