#include "eval/execution/methods.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/bop/layout.h"
#include "eval/cell/simulated_cell.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr double kNearBin_m = 0.3;    // distance beyond the bin at which a pose is elsewhere
constexpr double kUnitShare = 0.9;    // share that shows the unit of all
constexpr double kInCamera_m = 0.05;  // nothing is so close to a camera

// Number of estimates whose origin is near the bin if translations are multiplied by `factor`.
size_t CountNearBin(const std::vector<DatasetEstimate>& estimates, const ExecutedScenes& scenes,
                    const Bin& bin, double factor) {
  const double reach_m = 0.5 * bin.inner_size_m.norm() + kNearBin_m;
  return std::count_if(estimates.begin(), estimates.end(), [&](const DatasetEstimate& estimate) {
    const ImageTruth& image = scenes.at(estimate.scene_id).truth.images.at(estimate.image_id);
    const Pose X_WC = image.X_CW->inverse();
    return (X_WC * (factor * estimate.X_CO.translation())).norm() < reach_m;
  });
}

void RequireIdsOf(const std::vector<DatasetEstimate>& estimates, const ExecutedScenes& scenes,
                  int objects) {
  for (const DatasetEstimate& estimate : estimates) {
    const auto scene = scenes.find(estimate.scene_id);
    const bool is_known =
        scene != scenes.end() && scene->second.truth.images.contains(estimate.image_id);
    CheckInput(is_known, fmt::format("{}: the dataset has no scene {} with an image {}; these are "
                                     "results of another dataset or split",
                                     estimate.place, estimate.scene_id, estimate.image_id));
    CheckInput(estimate.object_id >= 1 && estimate.object_id <= objects,
               fmt::format("{}: obj_id {}: {} has no such object; it has 1 to {}", estimate.place,
                           estimate.object_id, kModelsInfoFile, objects));
  }
}

// Adds the poses of all instances that are at least 10 % visible.
void AddTrueEstimates(const SceneTruth& scene, std::vector<DatasetEstimate>& estimates) {
  for (const auto& [image_id, image] : scene.images) {
    for (size_t i = 0; i < image.instances.size(); ++i) {
      const double visible = image.infos.at(i).visib_fract;
      if (visible < kCountedVisibility) continue;
      DatasetEstimate& estimate = estimates.emplace_back();
      estimate.scene_id = scene.scene_id;
      estimate.image_id = image_id;
      estimate.object_id = image.instances[i].object_id;
      estimate.score = visible;
      estimate.X_CO = image.instances[i].X_CO;
    }
  }
}

}  // namespace

Method MethodOf(const std::string& name, const std::vector<DatasetEstimate>& estimates) {
  std::vector<double> sorted;
  for (const DatasetEstimate& estimate : estimates) sorted.push_back(estimate.score);
  std::sort(sorted.begin(), sorted.end());
  Method method{name, {}};
  for (const DatasetEstimate& estimate : estimates) {
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), estimate.score);
    const double lower = static_cast<double>(first - sorted.begin());
    const double equal = static_cast<double>(last - first);
    method.images[{estimate.scene_id, estimate.image_id}].push_back(
        {estimate.object_id, estimate.X_CO, estimate.score,
         (lower + 0.5 * equal) / static_cast<double>(sorted.size())});
  }
  for (auto& [image, poses] : method.images) {
    std::ranges::stable_sort(
        poses, [](const MethodPose& a, const MethodPose& b) { return a.score > b.score; });
  }
  return method;
}

std::vector<DatasetEstimate> TrueEstimates(const fs::path& root, const std::string& split) {
  const std::vector<int> scenes = SceneIdsOf(root, split);
  CheckInput(!scenes.empty(),
             fmt::format("{}: has no scene folder such as 000001", (root / split).string()));
  std::vector<DatasetEstimate> estimates;
  for (const int scene_id : scenes) {
    AddTrueEstimates(ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault),
                     estimates);
  }
  return estimates;
}

std::vector<DatasetEstimate> OracleEstimates(const ExecutedScenes& scenes) {
  std::vector<DatasetEstimate> estimates;
  for (const auto& [scene_id, scene] : scenes) AddTrueEstimates(scene.truth, estimates);
  return estimates;
}

void RequireEstimatesOf(const fs::path& file, const std::vector<DatasetEstimate>& estimates,
                        const ExecutedScenes& scenes, const Bin& bin, int objects) {
  CheckInput(!estimates.empty(),
             fmt::format("{}: has no estimate, so there is nothing to execute", file.string()));
  RequireIdsOf(estimates, scenes, objects);
  const auto in_camera = std::ranges::count_if(estimates, [](const DatasetEstimate& estimate) {
    return estimate.X_CO.translation().norm() < kInCamera_m;
  });
  // The reader has converted millimetres to metres.
  const size_t near_as_metres = CountNearBin(estimates, scenes, bin, 1e3);
  const bool is_metres =
      static_cast<double>(in_camera) >= kUnitShare * static_cast<double>(estimates.size()) &&
      near_as_metres > 0;
  CheckInput(!is_metres,
             fmt::format("{}: t is in metres, but BOP results have millimetres: {} of {} poses are "
                         "in the bin only if t is in metres; multiply t by 1000",
                         file.string(), near_as_metres, estimates.size()));
  CheckInput(CountNearBin(estimates, scenes, bin, 1) > 0,
             fmt::format("{}: none of its {} poses is in or near the bin; these are results of "
                         "another dataset, or t is not in millimetres in the camera frame",
                         file.string(), estimates.size()));
}

std::string MissingImagesText(const fs::path& file, const Method& method,
                              const ExecutedScenes& scenes) {
  int all = 0, missing = 0;
  std::string first;
  for (const auto& [scene_id, scene] : scenes) {
    for (const auto& [image_id, image] : scene.truth.images) {
      ++all;
      if (method.images.contains({scene_id, image_id})) continue;
      if (missing++ == 0) first = fmt::format("scene {} image {}", scene_id, image_id);
    }
  }
  if (missing == 0) return "";
  return fmt::format(
      "{}: has no estimate for {} of {} images, the first is {}; their picks fail as no_proposal",
      file.string(), missing, all, first);
}

}  // namespace pickbed::eval
