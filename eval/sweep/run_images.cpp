#include "eval/sweep/run_images.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/bop/dataset_card.h"
#include "eval/bop/layout.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/scenario/scenario_text.h"
#include "sim/sensor/depth_noise.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

int SceneIdOf(BinIndex bin_index) { return int{bin_index} + 1; }

MakeDatasetOptions CardOptions(const fs::path& root) {
  MakeDatasetOptions options;
  options.out = root;
  options.split = kRunSplit;
  options.views = 0;  // one image per attempt
  return options;
}

void MakeImageFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  CheckInput(!error, fmt::format("cannot make the folder {}: {}; choose another image folder",
                                 folder.string(), error.message()));
}

// Content of kImageFolderFile.
std::string PathText(const fs::path& root) {
  return fs::weakly_canonical(fs::absolute(root)).string() + "\n";
}

// Whether the images of the results were written into this data set so far.
bool IsImageFolderOf(const fs::path& results, const fs::path& root) {
  const fs::path file = results / kImageFolderFile;
  return fs::exists(file) && ReadFileBytes(file) == PathText(root);
}

}  // namespace

RunImageWriter::RunImageWriter(const fs::path& root, uint64_t seed, BinIndex bin_index)
    : folder_(root / kRunSplit / SceneFolderName(SceneIdOf(bin_index))),
      unfinished_(folder_.parent_path() /
                  fmt::format(".{}.unfinished", SceneFolderName(SceneIdOf(bin_index)))) {
  stored_.seed = seed;
  stored_.bin_index = bin_index;
}

RunImageWriter::~RunImageWriter() = default;

void RunImageWriter::Begin(SimulatedCell& cell) {
  fs::remove_all(unfinished_);
  objects_ = cell.objects();
  writer_.emplace(unfinished_, static_cast<int>(objects_.size()));
  renderer_ = std::make_unique<SceneRenderer>(cell.TrueObjects(stored_.bin_index), cell.bin());
  stored_.sizes = cell.SizesOf(stored_.bin_index);
}

void RunImageWriter::OnStage(TrialStage stage, const AttemptState& attempt) {
  if (stage != TrialStage::kImage || !attempt.record.has_own_image()) return;
  if (!writer_) Begin(attempt.cell);
  const Observation& view = *attempt.view;
  const Camera& assumed = view.calibration.camera;
  const Camera& camera = attempt.cell.camera();
  LabelledImage labelled;
  labelled.color = view.frame.color;
  labelled.depth = DepthUnits(view.frame.depth_m, kDepthScale_mm);
  ImageTruth& truth = labelled.truth;
  truth.image_id = attempt.record.attempt;
  const CameraIntrinsics& k = assumed.intrinsics;
  truth.projection = {k.fx(), k.fy(), k.cx(), k.cy()};
  truth.depth_scale_mm = kDepthScale_mm;
  truth.X_CW = assumed.X_CW();
  std::vector<RenderInstance> instances;
  for (const PosedObject& posed : attempt.scene.objects) {
    instances.push_back({renderer_->ObjectMesh(posed.object), posed.X_WO,
                         static_cast<uint16_t>(posed.instance + 1)});
    truth.instances.push_back({posed.object + 1, camera.X_CW() * posed.X_WO});
  }
  labelled.masks = MasksOf(renderer_->renderer(), camera, instances, view.ids, labelled.depth);
  writer_->Add(labelled);
  stored_.Add(truth.image_id, attempt.scene);
}

void RunImageWriter::Finish() {
  if (!writer_) return;
  writer_->Finish();
  WriteFileAtomically(unfinished_ / kStoredScenesFile, StoredScenesText(stored_, objects_));
  fs::remove_all(folder_);
  std::error_code error;
  fs::rename(unfinished_, folder_, error);
  CheckInput(!error,
             fmt::format("cannot create the folder {}: {}", folder_.string(), error.message()));
}

void BeginRunDataset(const ScenarioSpec& spec, const ObjectSet& objects, const fs::path& root,
                     const fs::path& results, const std::string& identity, bool resume,
                     const std::vector<int>& finished) {
  const std::vector<int> before = SceneIdsOf(root, kRunSplit);
  const std::string folder = (root / kRunSplit).string();
  CheckInput(before.empty() || resume,
             fmt::format("{} already has {} scenes; resume the run, or choose another image folder",
                         folder, before.size()));
  CheckInput(before.empty() || ReadIdentity(root) == identity,
             fmt::format("{} has scenes of another run; choose another image folder", folder));
  CheckInput(before.empty() || !finished.empty(),
             fmt::format("{} has {} scenes, but the run has no finished trial, so they are of "
                         "other results; choose another image folder",
                         folder, before.size()));
  for (const int trial : finished) {
    CheckInput(std::binary_search(before.begin(), before.end(), trial + 1),
               fmt::format("{} has no images of the finished trial {}, which ran without them; "
                           "choose another results folder",
                           folder, trial));
  }
  for (const int scene_id : before) {
    const bool is_finished = std::ranges::find(finished, scene_id - 1) != finished.end();
    CheckInput(is_finished || IsImageFolderOf(results, root),
               fmt::format("{} has a scene of trial {}, which {} has not finished, so it is of "
                           "other results; choose another image folder",
                           folder, scene_id - 1, results.string()));
  }
  for (const char* name : {"models", "models_eval"}) {
    MakeImageFolder(root / name);
    WriteModels(root / name, objects);
  }
  MakeImageFolder(root / kRunSplit);
  MakeFolder(results);
  WriteFileAtomically(results / kImageFolderFile, PathText(root));
  WriteIdentity(root, identity);
  WriteFileAtomically(root / kDatasetScenarioFile, ScenarioText(spec, root));
  WriteDatasetCamera(root / kDatasetCameraFile, CameraOf(spec).intrinsics);
}

void FinishRunDataset(const ScenarioSpec& spec, const ObjectSet& objects, const fs::path& root,
                      const std::string& identity, const std::vector<int>& finished) {
  for (const int scene_id : SceneIdsOf(root, kRunSplit)) {
    if (std::ranges::find(finished, scene_id - 1) != finished.end()) continue;
    fs::remove_all(root / kRunSplit / SceneFolderName(scene_id));
  }
  WriteTargets(root, kRunSplit);
  WriteCards(spec, objects, CardOptions(root), identity);
}

}  // namespace pickbed::eval
