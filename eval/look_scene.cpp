#include "eval/look_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/state_hash.h"
#include "grasp/success_rules.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr double kSamePose = 1e-6;  // of two matrices' entries: rounding of their products

const PosedObject* PosedIn(const Scene& scene, int instance) {
  const auto found = std::find_if(scene.objects.begin(), scene.objects.end(),
                                  [&](const PosedObject& p) { return p.instance == instance; });
  return found == scene.objects.end() ? nullptr : &*found;
}

// Records of earlier versions have no hashes; but each hypothesis is there in the world and in the
// true part, which tells where that lay.
bool IsSceneOf(const PickRecord& look, const Scene& scene) {
  const uint64_t recorded = look.hashes[TrialStage::kScene];
  if (recorded != 0) return HashOf(scene) == recorded;
  return std::all_of(look.hypotheses.begin(), look.hypotheses.end(), [&](const auto& score) {
    if (score.instance < 0) return true;
    const PosedObject* posed = PosedIn(scene, score.instance);
    return posed != nullptr &&
           (posed->X_WO * score.X_OtrueObelieved).isApprox(score.X_WO, kSamePose);
  });
}

Scene AfterThePicksBefore(const TrialResult& trial, size_t look, const LookSetup& setup) {
  ExecuteOptions options;
  options.rule = DecidingRule(setup.success_rule);
  Scene scene = setup.cell.MakeScene(trial.scene).scene;
  for (size_t i = 0; i < look; ++i) {
    const PickRecord& pick = trial.picks[i];
    if (!pick.grasp) continue;
    const HypothesisScore& believed = pick.hypotheses.at(pick.chosen);
    scene = ExecuteGrasp(scene, setup.cell.objects(), *pick.grasp, setup.gripper,
                         {pick.aimed, believed.object, believed.X_WO}, options)
                .after;
  }
  return scene;
}

Scene OfTheSeries(const TrialResult& trial, int band, const LookSetup& setup) {
  const MadeSeries made = setup.cell.MakeSeries(trial.scene);
  for (const OccludedScene& occluded : made.series.scenes) {
    if (occluded.band == band) return occluded.scene;
  }
  return {};
}

}  // namespace

Scene SceneOfLook(const TrialResult& trial, size_t look, const LookSetup& setup) {
  const PickRecord& record = trial.picks.at(look);
  Scene scene = record.band >= 0 ? OfTheSeries(trial, record.band, setup)
                                 : AfterThePicksBefore(trial, look, setup);
  CheckInput(IsSceneOf(record, scene),
             fmt::format("the scene of trial {}, look {} cannot be made again as it was in the run",
                         trial.trial, record.pick));
  return scene;
}

}  // namespace pickbed
