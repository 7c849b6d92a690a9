#include "eval/bop/targets.h"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <utility>

#include "eval/bop/layout.h"
#include "eval/bop/scores.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

void CountVisible(const ImageTruth& image, ImageTargets& targets) {
  for (size_t i = 0; i < image.infos.size(); ++i) {
    if (!image.instances[i].is_usable || image.infos[i].visib_fract < kMinVisible) continue;
    ++targets.counts[image.instances[i].object_id];
  }
  targets.localised = !targets.counts.empty();
}

// Returns the image of a target that was taken with the sensor; none if no view was. An empty
// sensor takes the first view if no view has the plain file names.
std::optional<int> ImageOf(const DatasetTarget& target, const std::string& sensor) {
  for (const TargetView& view : target.views) {
    if (view.sensor == sensor) return view.image_id;
  }
  return target.views.empty() || sensor.empty() ? std::optional(target.image_id) : std::nullopt;
}

// Puts the images in the order in which they are `listed`; the others follow by number.
std::vector<ListedImage> Ordered(const SplitTargets& targets,
                                 const std::vector<ListedImage>& listed) {
  std::vector<int> scenes;
  std::map<int, std::vector<ListedImage>> images;
  std::set<std::pair<int, int>> known;
  const auto add = [&](const ListedImage& image) {
    if (!known.insert({image.scene_id, image.image_id}).second) return;
    std::vector<ListedImage>& of_scene = images[image.scene_id];
    if (of_scene.empty()) scenes.push_back(image.scene_id);
    of_scene.push_back(image);
  };
  for (const ListedImage& image : listed) add(image);
  for (const auto& [scene_id, of_scene] : targets.scenes) {
    for (const auto& [image_id, image] : of_scene) add({scene_id, image_id});
  }
  std::vector<ListedImage> order;
  for (const int scene_id : scenes) {
    order.insert(order.end(), images[scene_id].begin(), images[scene_id].end());
  }
  return order;
}

}  // namespace

SplitTargets TargetsOf(const fs::path& root, const std::string& split, const std::string& sensor) {
  const std::vector<int> scenes = SceneIdsOf(root, split);
  CheckInput(!scenes.empty(),
             fmt::format("{}: has no scene folder such as 000001", (root / split).string()));
  SplitTargets targets;
  std::vector<ListedImage> listed;
  const fs::path file19 = root / TargetsFileName(split, 19);
  const fs::path file24 = root / TargetsFileName(split, 24);
  const fs::path multi_view = root / MultiViewTargetsFileName(split);
  const bool has19 = fs::exists(file19), has24 = fs::exists(file24);
  const bool has_views = !has24 && fs::exists(multi_view);
  std::set<std::pair<int, int>> without_object;  // images that the first file lists so
  if (has19) {
    for (const DatasetTarget& target : ReadTargets(file19, ThrowFault)) {
      ImageTargets& image = targets.scenes[target.scene_id][target.image_id];
      if (!target.object_id) {
        without_object.insert({target.scene_id, target.image_id});
        continue;
      }
      CheckInput(target.count.has_value(), file19.string() + ": a target has no 'inst_count'");
      image.localised = true;
      image.counts[*target.object_id] = *target.count;
    }
  }
  if (has24 || has_views) {
    for (const DatasetTarget& target : ReadTargets(has24 ? file24 : multi_view, ThrowFault)) {
      const std::optional<int> image_id = ImageOf(target, sensor);
      if (!image_id) continue;
      targets.scenes[target.scene_id][*image_id].detected = true;
      listed.push_back({target.scene_id, *image_id});
    }
  }
  if (has19 && (has24 || has_views) && without_object.empty()) {
    targets.order = Ordered(targets, listed);
    return targets;
  }
  for (const int scene_id : scenes) {
    const SceneTruth scene =
        ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault, sensor);
    for (const auto& [id, image] : scene.images) {
      const bool is_counted = !has19 || without_object.contains({scene_id, id});
      if (!is_counted && (has24 || has_views)) continue;
      ImageTargets& image_targets = targets.scenes[scene_id][id];
      if (is_counted && image_targets.counts.empty()) CountVisible(image, image_targets);
      if (!has24 && !has_views) image_targets.detected = true;
    }
  }
  targets.order = Ordered(targets, listed);
  if (!has19) {
    targets.notes.push_back(fmt::format(
        "no {}: every instance of at least 10 % visible is a target", file19.filename().string()));
  }
  if (!without_object.empty()) {
    targets.notes.push_back(
        fmt::format("{} lists images without obj_id: there, every instance of at least 10 % "
                    "visible is a target",
                    file19.filename().string()));
  }
  if (has_views) {
    targets.notes.push_back(
        fmt::format("no {}: the first view of the camera in each target of {} is a target",
                    file24.filename().string(), multi_view.filename().string()));
  } else if (!has24) {
    targets.notes.push_back(
        fmt::format("no {}: every image is a target", file24.filename().string()));
  }
  return targets;
}

}  // namespace pickbed::eval
