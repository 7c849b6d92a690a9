#include "eval/bop/dataset_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "eval/bop/layout.h"
#include "eval/bop/read_dataset.h"
#include "eval/bop/targets.h"
#include "eval/tolerance/maps.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

// Mean time per image in seconds, -1 if the time of any estimate is unknown.
double MeanTime(const std::vector<DatasetEstimate>& estimates) {
  std::map<std::pair<int, int>, double> times_s;
  for (const DatasetEstimate& estimate : estimates) {
    if (estimate.time_s < 0) return -1;
    times_s[{estimate.scene_id, estimate.image_id}] = estimate.time_s;
  }
  double sum = 0;
  for (const auto& [image, seconds] : times_s) sum += seconds;
  return times_s.empty() ? -1 : sum / times_s.size();
}

// Returns a note if the translations are most probably in metres; else an empty text.
std::string UnitNote(const std::vector<DatasetEstimate>& estimates) {
  constexpr double kNear_m = 0.05;  // nothing is so close to a camera
  constexpr double kShare = 0.9;
  const auto in_camera = std::ranges::count_if(estimates, [](const DatasetEstimate& estimate) {
    return estimate.X_CO.translation().norm() < kNear_m;
  });
  if (in_camera == 0 ||
      static_cast<double>(in_camera) < kShare * static_cast<double>(estimates.size())) {
    return "";
  }
  return fmt::format(
      "{} of {} estimates are less than 5 cm from the camera; t must be in millimetres", in_camera,
      estimates.size());
}

using EstimatesByImage = std::map<std::pair<int, int>, std::vector<const DatasetEstimate*>>;

// Throws InputError for an object that models_info.json in `folder` does not have.
EstimatesByImage ByImage(const std::vector<DatasetEstimate>& estimates,
                         const std::map<int, DatasetModelInfo>& models, const fs::path& folder) {
  EstimatesByImage by_image;
  for (const DatasetEstimate& estimate : estimates) {
    CheckInput(
        models.contains(estimate.object_id),
        fmt::format("{}: obj_id {}: {} has no such object",
                    estimate.place.empty() ? fmt::format("estimate of scene {} image {}",
                                                         estimate.scene_id, estimate.image_id)
                                           : estimate.place,
                    estimate.object_id, (folder / kModelsInfoFile).string()));
    by_image[{estimate.scene_id, estimate.image_id}].push_back(&estimate);
  }
  return by_image;
}

ScoredImage TruthOf(const ImageTruth& image, const RgbdFrame& frame) {
  ScoredImage truth{frame.intrinsics, frame.depth_m, {}};
  for (size_t i = 0; i < image.instances.size(); ++i) {
    const DatasetInstance& instance = image.instances[i];
    if (!instance.is_usable) continue;
    truth.instances.push_back({instance.object_id, instance.X_CO, image.infos[i].visib_fract});
  }
  return truth;
}

}  // namespace

TolerancesById ReadTolerances(const std::vector<std::string>& texts) {
  TolerancesById tolerances;
  for (const std::string& text : texts) {
    const size_t equals = text.find('=');
    int id = -1;
    const char* end = text.data() + (equals == std::string::npos ? 0 : equals);
    const auto [stop, error] = std::from_chars(text.data(), end, id);
    CheckInput(
        error == std::errc() && stop == end,
        fmt::format(
            "tolerance map {}: write ID=PLACE, an obj_id of the dataset and the folder of its map",
            text));
    const std::vector<fs::path> files = ToleranceFiles(text.substr(equals + 1));
    CheckInput(files.size() == 1,
               fmt::format("tolerance map {}: has {} maps; name one", text, files.size()));
    const bool is_new =
        tolerances.insert({id, {files.front(), ReadToleranceModel(files.front())}}).second;
    CheckInput(is_new, fmt::format("tolerance map {}: object {} already has one", text, id));
  }
  return tolerances;
}

int MaxEstimatesOf(const fs::path& root) {
  const std::string name = fs::absolute(root / "x").lexically_normal().parent_path().filename();
  return name == "xyzibd" ? kMaxEstimatesOfXyzibd : kMaxEstimatesOfImage;
}

DatasetScores EvaluateDataset(const fs::path& root, const std::string& split,
                              const std::vector<DatasetEstimate>& estimates,
                              const ScoreOptions& options, const TolerancesById& tolerances,
                              const std::function<void(const std::string&)>& on_scene) {
  const SplitTargets targets = TargetsOf(root, split, options.sensor);
  const fs::path folder = EvalModelsFolder(root);
  const std::map<int, DatasetModelInfo> models = ReadModelsInfo(folder, ThrowFault);
  ScoreAccumulator evaluator(
      [&](int object_id) {
        const auto info = models.find(object_id);
        CheckInput(info != models.end(),
                   fmt::format("{}: has no object {}, which is in the ground truth of a scene",
                               (folder / kModelsInfoFile).string(), object_id));
        auto model = LoadDatasetModel(folder, object_id, info->second, ModelName(object_id));
        if (const auto named = tolerances.find(object_id); named != tolerances.end()) {
          RequireModelOf(named->second.model, *model, named->second.file);
        }
        return model;
      },
      options.vsd,
      [&](int object_id) -> const ToleranceModel* {
        const auto named = tolerances.find(object_id);
        return named == tolerances.end() ? nullptr : &named->second.model;
      },
      options.max_estimates > 0 ? options.max_estimates : MaxEstimatesOf(root));
  for (const auto& [id, named] : tolerances) {
    CheckInput(models.contains(id),
               fmt::format("tolerance map {}={}: {} has no such object", id, named.file.string(),
                           (folder / kModelsInfoFile).string()));
  }
  EstimatesByImage by_image = ByImage(estimates, models, folder);
  DatasetScores scores;
  scores.notes = targets.notes;
  if (std::string note = UnitNote(estimates); !note.empty()) {
    scores.notes.push_back(std::move(note));
  }
  scores.seconds_an_image = MeanTime(estimates);
  size_t rotations = 0, corrected = 0;
  const std::vector<std::pair<int, int>> camera_sizes = CameraSizes(root);
  SceneTruth scene;
  fs::path scene_folder;
  for (const auto& [scene_id, image_id] : targets.order) {
    if (const fs::path folder = root / split / SceneFolderName(scene_id); folder != scene_folder) {
      scene_folder = folder;
      if (on_scene) on_scene(scene_folder.string());
      scene = ReadSceneTruth(scene_folder, scene_id, ThrowFault, options.sensor);
      for (const auto& [id, image] : scene.images) {
        rotations += image.instances.size();
        corrected += std::ranges::count_if(image.instances, &DatasetInstance::is_corrected);
      }
      for (const std::string& row : scene.unusable) {
        scores.notes.push_back(row + "; the instance is left out");
      }
    }
    const auto truth = scene.images.find(image_id);
    CheckInput(truth != scene.images.end(),
               fmt::format("{}: has no image {}, which is a target",
                           (scene_folder / kSceneCameraFile).string(), image_id));
    auto found = by_image.extract({scene_id, image_id});
    const RgbdFrame frame = ReadDepthFrame(scene, truth->second);
    CheckImageSize(scene, truth->second, frame, camera_sizes);
    evaluator.AddImage(TruthOf(truth->second, frame), targets.scenes.at(scene_id).at(image_id),
                       found ? std::move(found.mapped()) : std::vector<const DatasetEstimate*>());
  }
  if (corrected > 0) {
    scores.notes.push_back(fmt::format(
        "{} of {} rotations of the ground truth are not orthonormal; the nearest rotation is used",
        corrected, rotations));
  }
  for (const auto& [image, left] : by_image) {
    scores.estimates_elsewhere += static_cast<int>(left.size());
  }
  evaluator.Finish(scores);
  return scores;
}

}  // namespace pickbed::eval
