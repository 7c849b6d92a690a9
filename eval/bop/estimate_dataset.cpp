#include "eval/bop/estimate_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "eval/bop/layout.h"
#include "eval/bop/models.h"
#include "eval/bop/read_dataset.h"
#include "eval/bop/targets.h"
#include "eval/explain/explain.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "sim/convex/convex_pieces.h"
#include "sim/sensor/depth_noise.h"
#include "sim/training_view_source.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

std::set<int> ObjectsOf(const SplitTargets& targets, const std::map<int, DatasetModelInfo>& models,
                        DatasetTask task) {
  std::set<int> objects;
  for (const auto& [scene_id, images] : targets.scenes) {
    for (const auto& [image_id, image] : images) {
      for (const auto& [object_id, count] : image.counts) objects.insert(object_id);
      if (image.counts.empty() || task == DatasetTask::kDetection) {
        for (const auto& [object_id, info] : models) objects.insert(object_id);
      }
    }
  }
  return objects;
}

bool HasReadings(const Image<float>& depth_m) {
  return std::ranges::any_of(depth_m.pixels(), [](float d) { return d > 0; });
}

// Median depth in metres. The image must have at least one reading. Used as a working distance
// because it needs no ground truth.
double MedianDepth(const Image<float>& depth_m) {
  std::vector<float> readings;
  for (const float d : depth_m.pixels()) {
    if (d > 0) readings.push_back(d);
  }
  std::nth_element(readings.begin(), readings.begin() + readings.size() / 2, readings.end());
  return readings[readings.size() / 2];
}

// Estimator and objects with their resources, set up for the camera of the first usable target
// image.
class Runner {
 public:
  Runner(const fs::path& root, const EstimateDatasetOptions& options, const std::set<int>& wanted,
         const std::map<int, DatasetModelInfo>& models, const RgbdFrame& first,
         const std::function<void(const EstimateDatasetProgress&)>& on_progress)
      : task_(options.task), bin_(options.bin), on_warning_(options.on_warning) {
    const EstimatorRow& row = EstimatorNamed(options.estimator.name);
    EstimatorSetup setup;
    DatasetObjects dataset = LoadDatasetObjects(root, wanted, models);
    setup.objects = std::move(dataset.objects);
    object_ids_ = std::move(dataset.ids);
    setup.spec = options.estimator;
    setup.refiner = options.refiner;
    setup.intrinsics = first.intrinsics;
    setup.working_distance_m = MedianDepth(first.depth_m);
    if (row.renders) {
      setup.objects = WithConvexPieces(setup.objects);
      ViewSourceOptions view_options;
      view_options.sensor = LoadSensorProfile(ScenarioSpec().sensor);
      view_options.camera = first.intrinsics;
      views_ = MakeSimViewSource(setup.objects, view_options);
    }
    setup.threads = options.threads;
    setup.views = views_.get();
    setup.log_dir = options.log_dir;
    setup.cache_dir = CacheDir();
    if (on_progress) {
      setup.on_progress = [on_progress](std::string_view what, double share) {
        on_progress({std::string(what), share});
      };
    }
    estimator_ = MakeEstimator(setup);
    objects_ = setup.objects;
    working_distance_m_ = setup.working_distance_m;
  }

  EstimateResult Explain(const RgbdFrame& frame, const ImageTruth& image,
                         const ImageTargets& targets, Rng& rng, EstimateTrace& trace) {
    return estimator_->Estimate({frame, Background(image), &trace, Instances(targets)}, rng);
  }
  const std::vector<int>& object_ids() const { return object_ids_; }
  const ObjectSet& objects() const { return objects_; }
  LabelledViewSource& views() { return *views_; }
  double working_distance_m() const { return working_distance_m_; }

  void Run(const RgbdFrame& frame, const ImageTruth& image, const ImageTargets& targets,
           DatasetEstimate place, Rng& rng, std::vector<DatasetEstimate>& estimates) {
    const auto start = std::chrono::steady_clock::now();
    EstimatorInput input{frame, Background(image), nullptr, Instances(targets)};
    input.is_first = std::exchange(is_first_, false);
    const EstimateResult result = estimator_->Estimate(input, rng);
    if (result.failure) Warn(place, *result.failure);
    ++images_;
    without_background_ += !result.has_background;
    place.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const PoseHypothesis& hypothesis : result.hypotheses) {
      place.object_id = object_ids_[hypothesis.object];
      place.score = hypothesis.score;
      place.X_CO = hypothesis.X_CO;
      estimates.push_back(place);
    }
  }

  // Warns if the estimator recognised no background in some images.
  void WarnOfBackground() const {
    if (!on_warning_ || without_background_ == 0) return;
    on_warning_(
        fmt::format("no table, floor or bin was recognised in {} of {} images: poses on them may "
                    "have high scores",
                    without_background_, images_));
  }

 private:
  std::optional<KnownBackground> Background(const ImageTruth& image) const {
    if (!bin_ || !image.X_CW) return std::nullopt;
    return KnownBackground{*bin_, *image.X_CW};
  }

  void Warn(const DatasetEstimate& place, const EstimatorFailure& failure) const {
    if (!on_warning_) return;
    on_warning_(fmt::format("image {}/{}: {}", place.scene_id, place.image_id, failure.text));
    for (const std::string& line : failure.traceback) on_warning_("  " + line);
  }

  std::vector<int> Instances(const ImageTargets& targets) const {
    if (task_ == DatasetTask::kDetection || targets.counts.empty()) return {};
    std::vector<int> instances;
    for (const int id : object_ids_) {
      const auto count = targets.counts.find(id);
      instances.push_back(count == targets.counts.end() ? 0 : count->second);
    }
    return instances;
  }

  DatasetTask task_;
  std::optional<Bin> bin_;
  std::function<void(const std::string& line)> on_warning_;
  bool is_first_ = true;  // the next image
  int images_ = 0, without_background_ = 0;
  std::vector<int> object_ids_;
  ObjectSet objects_;
  double working_distance_m_ = 0;
  std::unique_ptr<LabelledViewSource> views_;
  std::unique_ptr<PoseEstimator> estimator_;
};

const ImageTruth& TargetImage(const SceneTruth& scene, int image_id) {
  const auto image = scene.images.find(image_id);
  CheckInput(image != scene.images.end(),
             fmt::format("{}: has no image {}, which is a target",
                         (scene.folder / kSceneCameraFile).string(), image_id));
  return image->second;
}

using TakeImage = std::function<void(const DatasetEstimate& place, const ImageTruth& image,
                                     const ImageTargets& targets, const RgbdFrame& frame)>;

// Reads each target image from disk and passes it to `take`.
void ForEachTarget(const fs::path& root, const std::string& split, const SplitTargets& targets,
                   const TakeImage& take) {
  for (const auto& [scene_id, images] : targets.scenes) {
    const SceneTruth scene =
        ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault);
    for (const auto& [image_id, image_targets] : images) {
      DatasetEstimate place;
      place.scene_id = scene_id;
      place.image_id = image_id;
      const ImageTruth& image = TargetImage(scene, image_id);
      take(place, image, image_targets, ReadFrame(scene, image));
    }
  }
}

// First target image with a depth reading. Codebooks are built for its camera and median depth.
RgbdFrame FirstFrame(const fs::path& root, const std::string& split, const SplitTargets& targets) {
  for (const auto& [scene_id, images] : targets.scenes) {
    const SceneTruth scene =
        ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault);
    for (const auto& [image_id, image_targets] : images) {
      RgbdFrame frame = ReadFrame(scene, TargetImage(scene, image_id));
      if (HasReadings(frame.depth_m)) return frame;
    }
  }
  throw InputError(fmt::format("{}: no target image has a depth reading", (root / split).string()));
}

Rng RngOf(const EstimateDatasetOptions& options, const DatasetEstimate& place) {
  return Rng::Derive(options.seed, place.scene_id, fmt::format("bop/estimate/{}", place.image_id));
}

// Finds the target image named `name`: SCENE/IMAGE or its index among the targets.
DatasetEstimate NamedTarget(const SplitTargets& targets, const std::string& name) {
  std::vector<DatasetEstimate> places;
  for (const auto& [scene_id, images] : targets.scenes) {
    for (const auto& [image_id, image] : images) {
      DatasetEstimate& place = places.emplace_back();
      place.scene_id = scene_id;
      place.image_id = image_id;
      if (name == fmt::format("{}/{}", scene_id, image_id)) return place;
      if (name == std::to_string(places.size() - 1)) return place;
    }
  }
  CheckInput(!places.empty(), "the split has no target image to explain");
  throw InputError(
      fmt::format("image {}: is no target image; write SCENE/IMAGE, for example {}/{}, or its "
                  "number among the targets, 0 to {}",
                  name, places.front().scene_id, places.front().image_id, places.size() - 1));
}

// Ground truth of the objects that the estimator searches; nullopt if the image has none.
std::optional<std::vector<TrueInstance>> TruthOf(const ImageTruth& image,
                                                 const std::vector<int>& object_ids) {
  if (image.instances.empty()) return std::nullopt;
  std::vector<TrueInstance> instances;
  for (size_t i = 0; i < image.instances.size(); ++i) {
    const auto id = std::ranges::find(object_ids, image.instances[i].object_id);
    if (id == object_ids.end() || !image.instances[i].is_usable) continue;
    const double visible = i < image.infos.size() ? image.infos[i].visib_fract : 1;
    instances.push_back({ObjectId(id - object_ids.begin()), image.instances[i].X_CO, visible});
  }
  return instances;
}

}  // namespace

std::vector<DatasetEstimate> EstimateDataset(
    const fs::path& root, const std::string& split, const EstimateDatasetOptions& options,
    const std::function<void(const EstimateDatasetProgress&)>& on_progress) {
  EstimatorNamed(options.estimator.name);
  RefinerNamed(options.refiner);
  const std::map<int, DatasetModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  const SplitTargets targets = TargetsOf(root, split);
  size_t all = 0, done = 0;
  for (const auto& [scene_id, images] : targets.scenes) all += images.size();
  // All images are read once before the first is processed, which takes a small share of the time.
  // A broken image is thus reported at once. After hours of work, all estimates would be lost.
  ForEachTarget(
      root, split, targets,
      [](const DatasetEstimate&, const ImageTruth&, const ImageTargets&, const RgbdFrame&) {});
  std::optional<Runner> runner;
  std::vector<DatasetEstimate> estimates;
  ForEachTarget(root, split, targets,
                [&](const DatasetEstimate& place, const ImageTruth& image,
                    const ImageTargets& image_targets, const RgbdFrame& frame) {
                  const bool sees = HasReadings(frame.depth_m);
                  if (!runner && sees) {
                    runner.emplace(root, options, ObjectsOf(targets, models, options.task), models,
                                   frame, on_progress);
                  }
                  Rng rng = RngOf(options, place);
                  if (sees) runner->Run(frame, image, image_targets, place, rng, estimates);
                  ++done;
                  if (on_progress) {
                    on_progress({fmt::format("scene {} image {}", place.scene_id, place.image_id),
                                 static_cast<double>(done) / static_cast<double>(all)});
                  }
                });
  if (runner) runner->WarnOfBackground();
  return estimates;
}

ExplanationPage ExplainTarget(
    const fs::path& root, const std::string& split, const EstimateDatasetOptions& options,
    const std::string& image, const fs::path& folder,
    const std::function<void(const EstimateDatasetProgress&)>& on_progress) {
  RequireExplains(options.estimator.name);
  const std::map<int, DatasetModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  const SplitTargets targets = TargetsOf(root, split);
  const DatasetEstimate place = NamedTarget(targets, image);
  Runner runner(root, options, ObjectsOf(targets, models, options.task), models,
                FirstFrame(root, split, targets), on_progress);
  const SceneTruth scene =
      ReadSceneTruth(root / split / SceneFolderName(place.scene_id), place.scene_id, ThrowFault);
  const ImageTruth& truth = TargetImage(scene, place.image_id);
  const RgbdFrame frame = ReadFrame(scene, truth);
  EstimateTrace trace;
  Rng rng = RngOf(options, place);
  const ImageTargets& asked = targets.scenes.at(place.scene_id).at(place.image_id);
  const EstimateResult result = runner.Explain(frame, truth, asked, rng, trace);
  return WriteExplanation(
      {fmt::format("{} on {}, scene {} image {}", options.estimator.name, split, place.scene_id,
                   place.image_id),
       DatasetImageName(place.scene_id, place.image_id), frame, runner.objects(), trace,
       result.hypotheses, TruthOf(truth, runner.object_ids()), runner.views(),
       runner.working_distance_m()},
      folder);
}

}  // namespace pickbed::eval
