#include "eval/bop/estimate_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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
#include "eval/frames/frame_checks.h"
#include "eval/frames/image_estimator.h"
#include "eval/frames/region.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/error.h"
#include "scenes/base/finite_counts.h"

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

// Estimator and objects with their resources, set up for the camera of the first usable target
// image.
class Runner {
 public:
  Runner(DatasetObjects dataset, const EstimateDatasetOptions& options, const RgbdFrame& first,
         const std::function<void(const EstimateDatasetProgress&)>& on_progress)
      : task_(options.task),
        bin_(options.bin),
        region_(options.region),
        on_warning_(options.on_warning),
        is_first_(options.finished.empty()),
        object_ids_(std::move(dataset.ids)) {
    ImageEstimatorSetup setup{std::move(dataset.objects), options.estimator, options.refiner,
                              options.threads, options.log_dir};
    if (on_progress) {
      setup.on_progress = [on_progress](std::string_view what, double share) {
        on_progress({std::string(what), share});
      };
    }
    estimator_ = std::make_unique<ImageEstimator>(setup, first);
  }

  EstimateResult Explain(const RgbdFrame& frame, const ImageTruth& image,
                         const ImageTargets& targets, Rng& rng, EstimateTrace& trace) {
    EstimatorInput input{frame, Background(image), &trace, Instances(targets)};
    return EstimateIn(input, image, rng);
  }
  const std::vector<int>& object_ids() const { return object_ids_; }
  const ObjectSet& objects() const { return estimator_->objects(); }
  LabelledViewSource& views() { return estimator_->views(); }
  double working_distance_m() const { return estimator_->working_distance_m(); }

  void Run(const RgbdFrame& frame, const ImageTruth& image, const ImageTargets& targets,
           DatasetEstimate place, Rng& rng, DatasetEstimates& estimates, DatasetImageNote& note) {
    const auto start = std::chrono::steady_clock::now();
    EstimatorInput input{frame, Background(image), nullptr, Instances(targets)};
    input.is_first = std::exchange(is_first_, false);
    const int empty_before = empty_regions_;
    const EstimateResult result = EstimateIn(input, image, rng);
    if (empty_regions_ > empty_before) {
      note.warnings.push_back("the region of interest has no depth reading");
    }
    if (result.failure) {
      Warn(place, *result.failure);
      note.warnings.push_back(result.failure->text);
    }
    note.poses = result.hypotheses.size();
    note.has_background = result.has_background;
    note.warnings.insert(note.warnings.end(), result.domain_warnings.begin(),
                         result.domain_warnings.end());
    ++images_;
    without_background_ += !result.has_background;
    outside_domain_ += !result.domain_warnings.empty();
    if (first_domain_warning_.empty() && !result.domain_warnings.empty()) {
      first_domain_warning_ = fmt::format("image {}/{}: {}", place.scene_id, place.image_id,
                                          fmt::join(result.domain_warnings, "; "));
    }
    place.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const PoseHypothesis& hypothesis : result.hypotheses) {
      place.object_id = object_ids_[hypothesis.object];
      place.score = hypothesis.score;
      place.X_CO = hypothesis.X_CO;
      estimates.estimates.push_back(place);
    }
  }

  // Warns of images that are unlike the training images, that have nothing in the region of
  // interest, or in which the estimator recognised no background.
  void WarnOfImages() const {
    if (!on_warning_) return;
    if (outside_domain_ > 0) {
      on_warning_(fmt::format("{} of {} images are unlike the training images; the first: {}",
                              outside_domain_, images_, first_domain_warning_));
    }
    if (empty_regions_ > 0) {
      on_warning_(fmt::format("the region of interest has no depth reading in {} of {} images",
                              empty_regions_, images_));
    }
    for (const std::string& line : NotFiniteWarnings()) on_warning_(line);
    if (without_background_ == 0) return;
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

  // Estimates poses in the region of interest, if there is one.
  EstimateResult EstimateIn(EstimatorInput& input, const ImageTruth& image, Rng& rng) {
    if (region_.empty()) return estimator_->Estimate(input, rng);
    const ImageRegion region = MakeRegion(region_, input.frame, image.X_CW, objects());
    input.region = &region.pixels;
    empty_regions_ += !HasReadingIn(region, input.frame);
    EstimateResult result = estimator_->Estimate(input, rng);
    KeepPosesIn(region, input.frame.intrinsics, objects(), result.hypotheses);
    return result;
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
  RegionSpec region_;
  std::function<void(const std::string& line)> on_warning_;
  bool is_first_;  // the next image, of all images of the data set
  int images_ = 0, without_background_ = 0, outside_domain_ = 0, empty_regions_ = 0;
  std::string first_domain_warning_;
  std::vector<int> object_ids_;
  std::unique_ptr<ImageEstimator> estimator_;
};

// What CheckFrame() finds in the images of a data set.
class FrameDoubts {
 public:
  void Add(const DatasetEstimate& place, const std::vector<FrameFinding>& findings) {
    ++images_;
    if (!findings.empty()) findings_[{place.scene_id, place.image_id}] = findings;
    const bool has_error = !findings.empty() && findings.front().is_error;
    images_with_error_ += has_error;
    std::set<FrameFault> counted;
    for (const FrameFinding& finding : findings) {
      if (!counted.insert(finding.fault).second) continue;
      Doubt& doubt = doubts_[finding.fault];
      if (doubt.images++ > 0) continue;
      doubt.line = fmt::format("image {}/{}: {}", place.scene_id, place.image_id, finding.text);
      if (finding.is_error && error_.empty()) error_ = doubt.line;
    }
  }

  // Moves the color image as the findings of this image say.
  void RegisterColorOf(const DatasetEstimate& place, RgbdFrame& frame) const {
    const auto found = findings_.find({place.scene_id, place.image_id});
    if (found != findings_.end()) RegisterColor(found->second, frame);
  }

  // Returns what was found in one image.
  std::vector<std::string> TextsOf(const DatasetEstimate& place) const {
    std::vector<std::string> texts;
    const auto found = findings_.find({place.scene_id, place.image_id});
    if (found == findings_.end()) return texts;
    for (const FrameFinding& finding : found->second) texts.push_back(finding.text);
    return texts;
  }

  // Throws InputError if no image is usable. An image without readings is only skipped.
  // `place` names the images.
  void Report(const fs::path& place,
              const std::function<void(const std::string& line)>& on_warning) const {
    const auto holes = doubts_.find(FrameFault::kNoReadings);
    const int empty = holes == doubts_.end() ? 0 : holes->second.images;
    CheckInput(images_with_error_ < images_ || empty == images_ || images_ == 0,
               place.string() + ": " + error_);
    if (!on_warning) return;
    for (const auto& [fault, doubt] : doubts_) {
      on_warning(doubt.line + (doubt.images > 1
                                   ? fmt::format(" ({} images have this fault)", doubt.images)
                                   : ""));
    }
  }

 private:
  struct Doubt {
    std::string line;  // about the first image
    int images = 0;
  };
  std::map<std::pair<int, int>, std::vector<FrameFinding>> findings_;  // by scene and image
  int images_ = 0, images_with_error_ = 0;
  std::string error_;
  std::map<FrameFault, Doubt> doubts_;
};

const ImageTruth& TargetImage(const SceneTruth& scene, int image_id) {
  const auto image = scene.images.find(image_id);
  CheckInput(image != scene.images.end(),
             fmt::format("{}: has no image {}, which is a target",
                         (scene.folder / kSceneCameraFile).string(), image_id));
  return image->second;
}

// Returns whether the next image is wanted.
using TakeImage = std::function<bool(const DatasetEstimate& place, const ImageTruth& image,
                                     const ImageTargets& targets, RgbdFrame& frame)>;

// Reads each target image from disk and passes it to `take`, until it wants no more.
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
      RgbdFrame frame = ReadFrame(scene, image);
      if (!take(place, image, image_targets, frame)) return;
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

void EstimateDataset(const fs::path& root, const std::string& split,
                     const EstimateDatasetOptions& options, DatasetEstimates& result,
                     const std::function<void(const EstimateDatasetProgress&)>& on_progress) {
  EstimatorNamed(options.estimator.name);
  RefinerNamed(options.refiner);
  const std::map<int, DatasetModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  const SplitTargets targets = TargetsOf(root, split);
  for (const auto& [scene_id, images] : targets.scenes) result.images += images.size();
  const auto goes_on = [&] { return !options.stop || !options.stop(); };
  // All images are read once before the first is processed, which takes a small share of the time.
  // A broken image is thus reported at once, and not after hours of work.
  DatasetObjects objects =
      LoadDatasetObjects(root, ObjectsOf(targets, models, options.task), models);
  FrameDoubts doubts;
  ForEachTarget(root, split, targets,
                [&](const DatasetEstimate& place, const ImageTruth& image, const ImageTargets&,
                    const RgbdFrame& frame) {
                  doubts.Add(place, CheckFrame(frame, objects.objects, image.depth_scale_mm));
                  return goes_on();
                });
  if (!goes_on()) return;
  doubts.Report(root / split, options.on_warning);
  std::optional<Runner> runner;
  ForEachTarget(
      root, split, targets,
      [&](const DatasetEstimate& place, const ImageTruth& image, const ImageTargets& image_targets,
          RgbdFrame& frame) {
        doubts.RegisterColorOf(place, frame);
        const bool sees = HasReadings(frame.depth_m);
        // The first image sets up the estimator, also if it is finished, so that the estimates of
        // the others do not depend on the place of an interrupt.
        if (!runner && sees) runner.emplace(std::move(objects), options, frame, on_progress);
        if (options.finished.contains({place.scene_id, place.image_id})) {
          ++result.done;
          return goes_on();
        }
        Rng rng = RngOf(options, place);
        DatasetImageNote note{place.scene_id, place.image_id, 0, false, doubts.TextsOf(place)};
        const size_t before = result.estimates.size();
        if (sees) runner->Run(frame, image, image_targets, place, rng, result, note);
        if (options.on_image) options.on_image(note, std::span(result.estimates).subspan(before));
        result.notes.push_back(std::move(note));
        ++result.done;
        if (on_progress) {
          on_progress({fmt::format("scene {} image {}", place.scene_id, place.image_id),
                       static_cast<double>(result.done) / static_cast<double>(result.images)});
        }
        return goes_on();
      });
  if (runner) runner->WarnOfImages();
}

ExplanationPage ExplainTarget(
    const fs::path& root, const std::string& split, const EstimateDatasetOptions& options,
    const std::string& image, const fs::path& folder,
    const std::function<void(const EstimateDatasetProgress&)>& on_progress) {
  RequireExplains(options.estimator.name);
  const std::map<int, DatasetModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  const SplitTargets targets = TargetsOf(root, split);
  const DatasetEstimate place = NamedTarget(targets, image);
  Runner runner(LoadDatasetObjects(root, ObjectsOf(targets, models, options.task), models), options,
                FirstFrame(root, split, targets), on_progress);
  const SceneTruth scene =
      ReadSceneTruth(root / split / SceneFolderName(place.scene_id), place.scene_id, ThrowFault);
  const ImageTruth& truth = TargetImage(scene, place.image_id);
  RgbdFrame frame = ReadFrame(scene, truth);
  RegisterColor(CheckFrame(frame, runner.objects(), truth.depth_scale_mm), frame);
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
