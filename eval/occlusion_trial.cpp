// One trial of the experiment on occlusion: the scenes of one target's series, each with a look
// and one pick aimed at the target. Every scene is the one that was built, whatever the pick before
// it did: each look counts as a part that was dropped, asked for, and picked or lost.

#include <fmt/format.h>

#include <algorithm>

#include "eval/trial_impl.h"

namespace pickbed {
namespace {

// The start's, with the worst that any scene of the series showed.
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

void CountTarget(const Scene& scene, TrialResult& result) {
  const PickRecord& pick = result.picks.back();
  const auto target =
      std::find_if(scene.objects.begin(), scene.objects.end(),
                   [&](const PosedObject& posed) { return posed.instance == pick.target; });
  InstanceFate& fate = result.fates.emplace_back();
  fate.instance = pick.target;
  fate.object = target->object;
  fate.picked = pick.loss == Loss::kNone;
  fate.loss = pick.loss;
  fate.pick = pick.pick;
  ++result.parts_dropped;
  result.parts_cleared += fate.picked;
}

}  // namespace

TrialResult TrialRunner::Impl::RunSeries(int scene, TrialObserver* observer) {
  Live live;
  live.observer = observer;
  TrialResult& result = live.result;
  result.trial = result.scene = scene;
  MadeSeries made;
  {
    StageTimer timer(result.seconds, "drop");
    made = cell.MakeSeries(scene);
  }
  result.certificate = WorstOf(made);
  result.refused = made.start.refused;
  result.bands = made.bands;
  for (const OccludedScene& occluded : made.series.scenes) {
    live.scene = occluded.scene;
    live.failed.clear();
    PickOnce(live, made.series.target, occluded.band);
    CountTarget(occluded.scene, result);
    if (!on_progress) continue;
    const double share = static_cast<double>(result.picks.size()) / made.series.scenes.size();
    on_progress(fmt::format("trial {}", scene), share);
  }
  return std::move(result);
}

}  // namespace pickbed
