#include "eval/bop/make_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "eval/bop/dataset_card.h"
#include "eval/bop/layout.h"
#include "eval/bop/stored_scenes.h"
#include "eval/bop/write_scene.h"
#include "eval/cell/simulated_cell.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/scenario/scenario_text.h"
#include "sim/render/renderer.h"
#include "sim/sensor/depth_noise.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

// A hidden name, so that no reader takes it for a scene.
fs::path UnfinishedFolder(const fs::path& split, int scene_id) {
  return split / fmt::format(".{}.unfinished", SceneFolderName(scene_id));
}

// A dataset has exact ground truth.
ScenarioSpec WithoutCellErrors(ScenarioSpec spec) {
  spec.cell = {};
  return spec;
}

// State of a worker: the cell, and a separate renderer because the views differ from the cell's.
class SceneMaker {
 public:
  SceneMaker(const ScenarioSpec& spec, const ObjectSet& objects, const MakeDatasetOptions& options)
      : spec_(spec),
        options_(options),
        cell_(WithoutCellErrors(spec), objects),
        renderer_(cell_.objects(), cell_.bin()) {}

  void Make(int scene_id) {
    const BinIndex bin_index(scene_id - 1);
    const fs::path split = options_.out / options_.split;
    const fs::path unfinished = UnfinishedFolder(split, scene_id);
    fs::remove_all(unfinished);
    SceneWriter writer(unfinished, static_cast<int>(cell_.objects().size()));
    const Scene scene = cell_.MakeScene(bin_index).scene;
    StoredScenes stored{spec_.seed, bin_index, cell_.SizesOf(bin_index), {}};
    for (int view = 0; view < options_.views; ++view) {
      writer.Add(See(scene, bin_index, view));
      stored.Add(view, scene);
    }
    writer.Finish();
    WriteFileAtomically(unfinished / kStoredScenesFile, StoredScenesText(stored, cell_.objects()));
    std::error_code error;
    fs::rename(unfinished, split / SceneFolderName(scene_id), error);
    CheckInput(!error, fmt::format("cannot create the folder {}: {}",
                                   (split / SceneFolderName(scene_id)).string(), error.message()));
  }

 private:
  LabelledImage See(const Scene& scene, BinIndex bin_index, int view) {
    Camera camera = cell_.camera();
    if (view > 0) {
      Rng rng = Rng::Derive(spec_.seed, bin_index, fmt::format("bop/view/{}", view));
      camera = RandomCamera(spec_, {}, rng);
    }
    const RenderedImage image = cell_.Render(renderer_, scene, camera, bin_index, view);
    Rng rng = Rng::Derive(spec_.seed, bin_index, fmt::format("bop/sensor/{}", view));
    LabelledImage labelled;
    labelled.color = image.color;
    const IdealView ideal{image.depth_m, camera.intrinsics, &image.color};
    labelled.depth = DepthUnits(ApplySensorNoise(ideal, cell_.sensor(), rng), kDepthScale_mm);
    ImageTruth& truth = labelled.truth;
    truth.image_id = view;
    const CameraIntrinsics& k = camera.intrinsics;
    truth.projection = {k.fx(), k.fy(), k.cx(), k.cy()};
    truth.depth_scale_mm = kDepthScale_mm;
    truth.X_CW = camera.X_CW();
    std::vector<RenderInstance> instances;
    for (const PosedObject& posed : scene.objects) {
      instances.push_back({renderer_.ObjectMesh(posed.object), posed.X_WO,
                           static_cast<uint16_t>(posed.instance + 1)});
      truth.instances.push_back({posed.object + 1, *truth.X_CW * posed.X_WO});
    }
    labelled.masks = MasksOf(renderer_.renderer(), camera, instances, image.ids, labelled.depth);
    return labelled;
  }

  ScenarioSpec spec_;
  MakeDatasetOptions options_;
  SimulatedCell cell_;
  SceneRenderer renderer_;
};

// Returns the scenes already on disk. Throws InputError if they cannot be resumed.
std::vector<int> ScenesBefore(const MakeDatasetOptions& options, const std::string& identity) {
  const std::vector<int> before = SceneIdsOf(options.out, options.split);
  if (before.empty()) return before;
  CheckInput(options.resume,
             fmt::format("{} already has {} scenes; resume it, or choose another results folder",
                         (options.out / options.split).string(), before.size()));
  CheckInput(
      ReadIdentity(options.out) == identity,
      fmt::format("{} has scenes of other settings than these; choose another results folder",
                  (options.out / options.split).string()));
  return before;
}

}  // namespace

Camera RandomCamera(const ScenarioSpec& spec, const ViewSpread& spread, Rng& rng) {
  using Eigen::AngleAxisd;
  constexpr int kMaxSamples = 100;
  const Camera nominal = CameraOf(spec);
  const double distance_m = (spec.camera.target_m - spec.camera.eye_m).norm();
  const double min_z_m = spec.bin.inner_size_m.z() + spread.above_walls_m;
  for (int i = 0; i < kMaxSamples; ++i) {
    const double turn = rng.Uniform(-std::numbers::pi, std::numbers::pi);
    const double tilt = rng.Uniform(-spread.tilt_rad, spread.tilt_rad);
    const double roll = rng.Uniform(-spread.roll_rad, spread.roll_rad);
    const double share = rng.Uniform(spread.distance_min, spread.distance_max);
    const double x_m = rng.Uniform(-spread.target_m, spread.target_m);
    const double y_m = rng.Uniform(-spread.target_m, spread.target_m);
    const Eigen::Matrix3d R_WC =
        AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * nominal.X_WC().linear() *
        (AngleAxisd(tilt, Eigen::Vector3d::UnitX()) * AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    const Eigen::Vector3d target_W = spec.camera.target_m + Eigen::Vector3d(x_m, y_m, 0);
    const Eigen::Vector3d eye_W = target_W - share * distance_m * R_WC.col(2);
    if (eye_W.z() < min_z_m) continue;
    return {nominal.intrinsics, MakePose(Orthonormalized(R_WC), eye_W)};
  }
  return nominal;  // it is so low that no sampled view is high enough above the walls
}

std::vector<LostItem> NotWritten(std::vector<LostItem> lost, const std::vector<int>& written) {
  std::erase_if(
      lost, [&](const LostItem& scene) { return std::ranges::binary_search(written, scene.item); });
  return lost;
}

MakeDatasetReport MakeDataset(const ScenarioSpec& spec, const ObjectSet& objects,
                              const MakeDatasetOptions& options,
                              const std::function<void(const MakeDatasetReport&)>& on_scene,
                              const std::function<bool()>& stop) {
  const std::string identity = IdentityOf(spec, objects, options);
  const std::vector<int> before = ScenesBefore(options, identity);
  const std::array<fs::path, 2> models{options.out / "models", options.out / "models_eval"};
  for (const fs::path& folder : models) MakeFolder(folder);
  MakeFolder(options.out / options.split);
  WriteIdentity(options.out, identity);
  WriteFileAtomically(options.out / kDatasetScenarioFile,
                      ScenarioText(WithoutCellErrors(spec), options.out));
  // The BOP toolkit needs meshes for rendering and for scoring. These are small enough for both.
  for (const fs::path& folder : models) WriteModels(folder, objects);
  WriteDatasetCamera(options.out / kDatasetCameraFile, CameraOf(spec).intrinsics);

  MakeDatasetReport report;
  report.done = report.done_before = static_cast<int>(std::count_if(
      before.begin(), before.end(), [&](int id) { return id >= 1 && id <= options.scenes; }));
  WorkerPlan plan;
  for (int id = 1; id <= options.scenes; ++id) {
    if (!std::binary_search(before.begin(), before.end(), id)) plan.items.push_back(id);
  }
  plan.jobs = options.jobs;
  plan.stop = stop;
  plan.start = [&](const WorkerPlan::Say&) -> WorkerPlan::DoItem {
    auto maker = std::make_shared<SceneMaker>(spec, objects, options);
    return [maker](int scene_id) {
      maker->Make(scene_id);
      return std::string();
    };
  };
  plan.on_done = [&](int, const std::string&) {
    ++report.done;
    if (on_scene) on_scene(report);
  };
  WorkReport work = RunInWorkers(plan);
  report.stopped = work.stopped;
  const size_t unconfirmed = work.lost.size();
  report.lost = NotWritten(std::move(work.lost), SceneIdsOf(options.out, options.split));
  report.done += static_cast<int>(unconfirmed - report.lost.size());
  if (report.stopped || !report.lost.empty()) return report;
  WriteTargets(options.out, options.split);
  WriteCards(spec, objects, options, identity);
  return report;
}

}  // namespace pickbed::eval
