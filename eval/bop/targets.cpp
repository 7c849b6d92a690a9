#include "eval/bop/targets.h"

#include <fmt/format.h>

#include "eval/bop/layout.h"
#include "eval/bop/scores.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

void CountVisible(const ImageTruth& image, ImageTargets& targets) {
  for (size_t i = 0; i < image.infos.size(); ++i) {
    if (image.infos[i].visib_fract < kMinVisible) continue;
    ++targets.counts[image.instances[i].object_id];
  }
  targets.localised = !targets.counts.empty();
}

}  // namespace

SplitTargets TargetsOf(const fs::path& root, const std::string& split) {
  const std::vector<int> scenes = SceneIdsOf(root, split);
  CheckInput(!scenes.empty(),
             fmt::format("{}: has no scene folder such as 000001", (root / split).string()));
  SplitTargets targets;
  const fs::path file19 = root / TargetsFileName(split, 19);
  const fs::path file24 = root / TargetsFileName(split, 24);
  const bool has19 = fs::exists(file19), has24 = fs::exists(file24);
  if (has19) {
    for (const DatasetTarget& target : ReadTargets(file19, ThrowFault)) {
      CheckInput(target.object_id && target.count,
                 file19.string() + ": a target has no 'obj_id' or no 'inst_count'");
      ImageTargets& image = targets.scenes[target.scene_id][target.image_id];
      image.localised = true;
      image.counts[*target.object_id] = *target.count;
    }
  }
  if (has24) {
    for (const DatasetTarget& target : ReadTargets(file24, ThrowFault)) {
      targets.scenes[target.scene_id][target.image_id].detected = true;
    }
  }
  if (has19 && has24) return targets;
  for (const int scene_id : scenes) {
    const SceneTruth scene =
        ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault);
    for (const auto& [id, image] : scene.images) {
      ImageTargets& image_targets = targets.scenes[scene_id][id];
      if (!has19) CountVisible(image, image_targets);
      if (!has24) image_targets.detected = true;
    }
  }
  if (!has19) {
    targets.notes.push_back(fmt::format(
        "no {}: every instance of at least 10 % visible is a target", file19.filename().string()));
  }
  if (!has24) {
    targets.notes.push_back(
        fmt::format("no {}: every image is a target", file24.filename().string()));
  }
  return targets;
}

}  // namespace pickbed::eval
