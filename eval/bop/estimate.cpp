#include "eval/bop/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>

#include "eval/bop/card.h"
#include "eval/bop/dataset.h"
#include "eval/bop/layout.h"
#include "eval/bop/targets.h"
#include "perception/pose_estimator.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "sim/convex_pieces.h"
#include "sim/sensor_noise.h"
#include "sim/view_source.h"

namespace pickbed::bop {
namespace {

namespace fs = std::filesystem;

const EstimatorRow& RowOf(const std::string& name) {
  std::vector<std::string> names;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (row.name == name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("estimator for BOP data", name, names));
}

std::set<int> ObjectsOf(const SplitTargets& targets, const std::map<int, ModelInfo>& models) {
  std::set<int> objects;
  for (const auto& [scene_id, images] : targets.scenes) {
    for (const auto& [image_id, image] : images) {
      for (const auto& [object_id, count] : image.counts) objects.insert(object_id);
      if (image.counts.empty()) {
        for (const auto& [object_id, info] : models) objects.insert(object_id);
      }
    }
  }
  return objects;
}

// The middle reading: a working distance that needs no truth.
double MiddleDepth(const Image<float>& depth_m) {
  std::vector<float> readings;
  for (const float d : depth_m.pixels()) {
    if (d > 0) readings.push_back(d);
  }
  CheckInput(!readings.empty(), "the first target image has no depth reading");
  std::nth_element(readings.begin(), readings.begin() + readings.size() / 2, readings.end());
  return readings[readings.size() / 2];
}

// Estimator, parts and what they need, made for the camera of the first target image.
class Runner {
 public:
  Runner(const fs::path& root, const EstimateOptions& options, const std::set<int>& wanted,
         const std::map<int, ModelInfo>& models, const RgbdFrame& first,
         const std::function<void(const EstimateProgress&)>& on_progress) {
    const EstimatorRow& row = RowOf(options.estimator.name);
    const std::map<int, CardPart> known_parts = PartsOfCard(root);
    EstimatorSetup setup;
    for (const int id : wanted) {
      const auto info = models.find(id);
      CheckInput(info != models.end(),
                 fmt::format("{}: has no object {}, which is a target",
                             (root / "models" / "models_info.json").string(), id));
      const auto known = known_parts.find(id);
      const std::string name = known != known_parts.end() ? known->second.name : ModelName(id);
      auto model =
          std::make_shared<ObjectModel>(*LoadModel(root / "models", id, info->second, name));
      if (known != known_parts.end()) model->mesh_hash = known->second.mesh_hash;
      setup.objects.push_back(std::move(model));
      object_ids_.push_back(id);
    }
    setup.spec = options.estimator;
    setup.refiner = options.refiner;
    setup.intrinsics = first.intrinsics;
    setup.working_distance_m = MiddleDepth(first.depth_m);
    if (row.renders) {
      setup.objects = WithConvexPieces(setup.objects);
      ViewSourceOptions view_options;
      view_options.sensor = LoadSensorProfile(ScenarioSpec().sensor);
      view_options.camera = first.intrinsics;
      views_ = MakeSimViewSource(setup.objects, view_options);
    }
    setup.views = views_.get();
    setup.cache_dir = CacheDir();
    if (on_progress) {
      setup.on_progress = [on_progress](std::string_view what, double share) {
        on_progress({std::string(what), share});
      };
    }
    estimator_ = row.make(setup);
  }

  void Run(const RgbdFrame& frame, const ImageTargets& targets, Estimate place, Rng& rng,
           std::vector<Estimate>& estimates) {
    const auto start = std::chrono::steady_clock::now();
    const EstimateResult result = estimator_->Estimate({frame, std::nullopt}, rng);
    place.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const PoseHypothesis& hypothesis : result.hypotheses) {
      place.object_id = object_ids_[hypothesis.object];
      if (!targets.counts.empty() && !targets.counts.contains(place.object_id)) continue;
      place.score = hypothesis.score;
      place.X_CO = hypothesis.X_CO;
      estimates.push_back(place);
    }
  }

 private:
  std::vector<int> object_ids_;
  std::unique_ptr<LabelledViewSource> views_;
  std::unique_ptr<PoseEstimator> estimator_;
};

using TakeImage =
    std::function<void(const Estimate& place, const ImageTargets& targets, const RgbdFrame& frame)>;

// Every image that is a target, read from disk.
void ForEachTarget(const fs::path& root, const std::string& split, const SplitTargets& targets,
                   const TakeImage& take) {
  for (const auto& [scene_id, images] : targets.scenes) {
    const SceneTruth scene =
        ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault);
    for (const auto& [image_id, image_targets] : images) {
      const auto image = scene.images.find(image_id);
      CheckInput(image != scene.images.end(),
                 fmt::format("{}: has no image {}, which is a target",
                             (scene.folder / "scene_camera.json").string(), image_id));
      Estimate place;
      place.scene_id = scene_id;
      place.image_id = image_id;
      take(place, image_targets, ReadFrame(scene, image->second));
    }
  }
}

}  // namespace

std::vector<Estimate> EstimateDataset(
    const fs::path& root, const std::string& split, const EstimateOptions& options,
    const std::function<void(const EstimateProgress&)>& on_progress) {
  RowOf(options.estimator.name);
  const std::map<int, ModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  const SplitTargets targets = TargetsOf(root, split);
  size_t all = 0, done = 0;
  for (const auto& [scene_id, images] : targets.scenes) all += images.size();
  // All are read once before the first is worked on, a small share of the time: a broken one is
  // told of now and not after hours, whose estimates would be lost.
  ForEachTarget(root, split, targets,
                [](const Estimate&, const ImageTargets&, const RgbdFrame&) {});
  std::optional<Runner> runner;
  std::vector<Estimate> estimates;
  ForEachTarget(
      root, split, targets,
      [&](const Estimate& place, const ImageTargets& image_targets, const RgbdFrame& frame) {
        if (!runner) {
          runner.emplace(root, options, ObjectsOf(targets, models), models, frame, on_progress);
        }
        Rng rng = Rng::Derive(options.seed, place.scene_id,
                              fmt::format("bop/estimate/{}", place.image_id));
        runner->Run(frame, image_targets, place, rng, estimates);
        ++done;
        if (on_progress) {
          on_progress({fmt::format("scene {} image {}", place.scene_id, place.image_id),
                       static_cast<double>(done) / static_cast<double>(all)});
        }
      });
  return estimates;
}

}  // namespace pickbed::bop
