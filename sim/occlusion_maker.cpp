#include "sim/occlusion_maker.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/check.h"

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

std::string WhyNone(const MadeSeries& made, const SceneRequest& request,
                    const OcclusionSetup& setup) {
  const OcclusionSpec& spec = setup.spec;
  const double least = spec.Inner(static_cast<int>(spec.bands.size()) - 1).least;
  if (made.targets_tried == 0) {
    return fmt::format(
        "trial {}: in {} scene{} no part had {:.1f} % of it in view, with which a series on "
        "occlusion begins; look from higher up, drop fewer parts or end the bands lower",
        request.trial, spec.scenes, spec.scenes == 1 ? "" : "s", 100 * least);
  }
  BlockerCounts counts;
  for (const BandAccount& band : made.bands) counts.Add(band.blockers);
  return fmt::format(
      "trial {}: no band of visible fraction could be filled with {} target{}: of {} blockers {} "
      "hid too little, {} too much, and {} disturbed the scene; widen occlusion.bands, raise "
      "occlusion.tries or drop other parts",
      request.trial, made.targets_tried, made.targets_tried == 1 ? "" : "s", counts.dropped,
      counts.useless, counts.jumped, counts.refused);
}

}  // namespace

MadeSeries MakeOcclusionSeries(SceneRenderer& renderer, const SceneRequest& request,
                               const std::vector<int>& wanted, const OcclusionSetup& setup) {
  const OcclusionSpec& spec = setup.spec;
  MadeSeries made;
  made.bands.resize(spec.bands.size());
  std::vector<RefusedScene> refused;
  for (int scene = 0; scene < spec.scenes; ++scene) {
    SceneRequest attempt = request;
    if (scene > 0) attempt.stage = fmt::format("{}/scene_{}", request.stage, scene);
    CertifiedScene start = MakeScene(attempt, setup.drop);
    for (RefusedScene& faulty : start.refused) {
      refused.push_back({static_cast<int>(refused.size()), std::move(faulty.faults)});
    }
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
  CheckInput(!made.series.scenes.empty(), WhyNone(made, request, setup));
  made.start.refused = std::move(refused);
  for (const OccludedScene& scene : made.series.scenes) made.bands[scene.band].filled = true;
  return made;
}

}  // namespace pickbed
