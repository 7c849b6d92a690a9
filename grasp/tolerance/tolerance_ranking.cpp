#include "grasp/tolerance/tolerance_ranking.h"

#include <fmt/format.h>

#include "grasp/tolerance/model_files.h"
#include "scenes/base/files.h"
#include "scenes/base/math.h"
#include "scenes/base/random.h"

namespace pickbed::grasp {
namespace {

bool RanksByTolerance(const ScenarioSpec& spec) { return spec.policy.ranking == kToleranceRanking; }

void RequireMaps(const ScenarioSpec& spec) {
  CheckInput(!spec.policy.tolerance_maps.empty(),
             fmt::format("{} = {}: needs tolerance maps; make them with pickbed tolerance OBJECT "
                         "GRIPPER, and name their folder in policy.tolerance_maps",
                         spec.At("policy.ranking"), spec.policy.ranking));
}

}  // namespace

void FillTolerance(const ScenarioSpec& spec, const ObjectSet& objects, const std::string& gripper,
                   std::vector<std::vector<GraspCandidate>>& candidates) {
  if (!RanksByTolerance(spec)) return;
  RequireMaps(spec);
  const PolicySpec& policy = spec.policy;
  const PoseUncertainty uncertainty{1e-3 * policy.pose_error_mm,
                                    policy.pose_error_deg / kDegreesPerRadian};
  WithSettingsKey(spec, "policy.tolerance_maps", [&] {
    const auto models = LoadToleranceModels({policy.tolerance_maps}, objects, gripper);
    for (size_t i = 0; i < candidates.size(); ++i) {
      if (candidates[i].empty()) continue;
      CheckInput(
          models[i].has_value(),
          fmt::format("{} has no map of {} with {}; make one with pickbed tolerance {} {}",
                      policy.tolerance_maps, objects[i]->name, gripper, objects[i]->name, gripper));
      for (GraspCandidate& candidate : candidates[i]) {
        candidate.tolerance = ExpectedSuccess(*models[i], *objects[i], candidate.X_OG, uncertainty);
      }
    }
  });
}

std::string ToleranceRankingText(const ScenarioSpec& spec) {
  if (!RanksByTolerance(spec)) return "";
  RequireMaps(spec);
  std::string text;
  WithSettingsKey(spec, "policy.tolerance_maps", [&] {
    for (const std::filesystem::path& file : ToleranceFiles(spec.policy.tolerance_maps)) {
      const std::string bytes = ReadFileBytes(file);
      text += fmt::format("# tolerance {:016x}\n", HashBytes(bytes.data(), bytes.size()));
    }
  });
  return text;
}

}  // namespace pickbed::grasp
