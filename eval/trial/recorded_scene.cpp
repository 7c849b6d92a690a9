#include "eval/trial/recorded_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/trial/grasp_choice.h"
#include "eval/trial/stage_hash.h"
#include "grasp/execute/stir.h"
#include "grasp/outcome.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

constexpr double kSamePose = 1e-6;  // relative tolerance of pose matrices: rounding of products

const PosedObject* PosedIn(const Scene& scene, InstanceId instance) {
  const auto found = std::find_if(scene.objects.begin(), scene.objects.end(),
                                  [&](const PosedObject& p) { return p.instance == instance; });
  return found == scene.objects.end() ? nullptr : &*found;
}

// Records of earlier versions have no hashes. They have each hypothesis in the world frame and in
// the frame of its matched instance; together these give the recorded pose of the instance.
bool IsSceneOf(const AttemptRecord& attempt, const Scene& scene) {
  const uint64_t recorded = attempt.hashes[TrialStage::kScene];
  if (recorded != 0) return HashOf(scene) == recorded;
  return std::all_of(attempt.hypotheses.begin(), attempt.hypotheses.end(), [&](const auto& score) {
    if (score.instance < 0) return true;
    const PosedObject* posed = PosedIn(scene, score.instance);
    return posed != nullptr && (posed->X_WO * score.X_OE).isApprox(score.X_WO, kSamePose);
  });
}

Scene AfterThePicksBefore(const TrialResult& trial, size_t attempt, const AttemptSetup& setup) {
  ExecuteOptions options;
  options.rule = DecidingRule(setup.success_rule);
  Scene scene = setup.cell.MakeScene(trial.bin_index).scene;
  const ObjectSet objects = setup.cell.TrueObjects(trial.bin_index);
  int stirs = 0;
  for (size_t i = 0; i < attempt; ++i) {
    const AttemptRecord& earlier = trial.attempts[i];
    if (Stirred(earlier)) {
      const Observation view = setup.cell.Capture(scene, trial.bin_index, earlier.attempt);
      const Gripper& tool = *setup.tools.front();
      const StirPath path = ChooseStir(setup.cell.bin(), tool, view, stirs++);
      scene = StirBin(scene, objects, tool, path).after;
    }
    if (!earlier.grasp) continue;
    GraspTarget target;  // any instance, of a grasp without a pose
    if (earlier.chosen >= 0) {
      const HypothesisRecord& estimated = earlier.hypotheses.at(earlier.chosen);
      target = {earlier.matched_instance, estimated.object, estimated.X_WO,
                setup.cell.objects().at(estimated.object).get()};
    }
    scene = ExecuteWithErrors({scene, objects}, *earlier.grasp,
                              ToolNamed(setup.tools, earlier.grasp->tool), target, options,
                              earlier.errors)
                .after;
  }
  return scene;
}

Scene OfTheSeries(const TrialResult& trial, int band, const AttemptSetup& setup) {
  const MadeSeries made = setup.cell.MakeSeries(trial.bin_index);
  for (const OccludedScene& occluded : made.series.scenes) {
    if (occluded.band == band) return occluded.scene;
  }
  throw InputError(
      fmt::format("the scene of trial {} for band {} cannot be reproduced: its series has no scene "
                  "for this band",
                  trial.trial, band));
}

}  // namespace

Scene SceneOfAttempt(const TrialResult& trial, size_t attempt, const AttemptSetup& setup) {
  const AttemptRecord& record = trial.attempts.at(attempt);
  Scene scene = record.band >= 0 ? OfTheSeries(trial, record.band, setup)
                                 : AfterThePicksBefore(trial, attempt, setup);
  CheckInput(
      IsSceneOf(record, scene),
      fmt::format("the scene of trial {}, attempt {} cannot be reproduced as it was in the run",
                  trial.trial, record.attempt));
  return scene;
}

}  // namespace pickbed::eval
