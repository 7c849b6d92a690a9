#include "sim/occlusion_maker.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/check.h"
#include "sim/scene_tries.h"

namespace pickbed {
namespace {

// In random order, the first few.
std::vector<int> DrawnTargets(std::vector<int> targets, int most, Rng& rng) {
  for (size_t i = targets.size(); i > 1; --i) {  // Fisher and Yates
    std::swap(targets[i - 1], targets[rng.Index(static_cast<int>(i))]);
  }
  if (targets.size() > static_cast<size_t>(most)) targets.resize(most);
  return targets;
}

// The series fills from the most visible band on: what comes after the first gap is empty, too.
void Charge(const OcclusionSeries& series, std::vector<BandAccount>& bands) {
  for (size_t i = 0; i < bands.size(); ++i) bands[i].blockers.Add(series.blockers[i]);
  const size_t empty = bands.size() - series.scenes.size();
  if (empty > 0) ++bands[empty - 1].given_up;
}

bool DropsAny(const std::vector<int>& wanted, const std::vector<int>& counts) {
  return std::any_of(wanted.begin(), wanted.end(), [&](int object) { return counts[object] > 0; });
}

}  // namespace

MadeSeries MakeOcclusionSeries(SceneRenderer& renderer, const SceneRequest& request,
                               const std::vector<int>& wanted, const OcclusionSetup& setup) {
  CheckInput(DropsAny(wanted, request.counts),
             "a trial on occlusion has no part that could be its target; raise the count of one "
             "that is not foreign");
  const OcclusionSpec& spec = setup.spec;
  MadeSeries made;
  made.bands.resize(spec.bands.size());
  std::vector<RefusedScene> refused;
  for (int scene = 0; scene < spec.scenes; ++scene) {
    SceneRequest attempt = request;
    if (scene > 0) attempt.stage = fmt::format("{}/scene_{}", request.stage, scene);
    SceneTries tries = TryScene(attempt, setup.drop);
    for (RefusedScene& faulty : tries.refused) {
      refused.push_back({static_cast<int>(refused.size()), std::move(faulty.faults)});
    }
    if (!tries.made) continue;
    const CertifiedScene& start = *tries.made;
    if (made.start.scene.objects.empty()) made.start = start;
    Rng order = Rng::Derive(request.seed, request.trial, fmt::format("occlude/{}", scene));
    for (const int target :
         DrawnTargets(PossibleTargets(renderer, start.scene, wanted, setup), spec.targets, order)) {
      Rng rng =
          Rng::Derive(request.seed, request.trial, fmt::format("occlude/{}/{}", scene, target));
      OcclusionSeries series =
          OccludeTarget(renderer, {start.scene, start.certificate}, target, setup, rng);
      ++made.targets_tried;
      Charge(series, made.bands);
      if (series.scenes.size() <= made.series.scenes.size()) continue;
      made.series = std::move(series);
      made.start = start;
      if (made.series.scenes.size() == spec.bands.size()) break;
    }
    if (made.series.scenes.size() == spec.bands.size()) break;
  }
  made.start.refused = std::move(refused);
  for (const OccludedScene& scene : made.series.scenes) made.bands[scene.band].filled = true;
  return made;
}

}  // namespace pickbed
