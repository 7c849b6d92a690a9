#include "eval/bop/check_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "eval/bop/layout.h"
#include "eval/bop/read_dataset.h"
#include "scenes/base/error.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::eval {
namespace {

// Whether a box x, y, width, height is within another one. A box without area says that there is
// nothing to see, so it is within each.
bool IsInside(const std::array<int, 4>& inner, const std::array<int, 4>& outer) {
  if (inner[2] <= 0 || inner[3] <= 0) return true;
  for (const int axis : {0, 1}) {
    if (inner[axis] < outer[axis]) return false;
    if (inner[axis] + inner[axis + 2] > outer[axis] + outer[axis + 2]) return false;
  }
  return true;
}

namespace fs = std::filesystem;

bool IsFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

class Checker {
 public:
  explicit Checker(fs::path root) : root_(std::move(root)) {}

  CheckDatasetReport Run(const std::function<void(const std::string&)>& on_scene) {
    CheckModels(root_ / "models", true);
    if (IsFolder(root_ / "models_eval")) CheckModels(root_ / "models_eval", false);
    CheckCameras();
    const std::vector<std::string> splits = SplitsOf(root_);
    if (splits.empty()) Fault(root_.string() + ": has no folder train*, val* or test*");
    for (const std::string& split : splits) {
      instances_.clear();
      const std::vector<int> scenes = SceneIdsOf(root_, split);
      if (scenes.empty()) Fault((root_ / split).string() + ": has no scene folder such as 000001");
      for (const int scene_id : scenes) {
        if (on_scene) on_scene(split + "/" + SceneFolderName(scene_id));
        CheckScene(split, scene_id);
      }
      for (const int year : {19, 24}) CheckTargets(split, year);
    }
    return std::move(report_);
  }

 private:
  void Fault(const std::string& line) { report_.faults.push_back(line); }
  OnFault Collector() {
    return [this](const std::string& line) { Fault(line); };
  }
  // Returns the result of `work`. Records its InputError as a fault and returns nullopt.
  template <typename Work>
  auto Try(Work work) -> std::optional<decltype(work())> {
    try {
      return work();
    } catch (const InputError& error) {
      Fault(error.what());
      return std::nullopt;
    }
  }

  void CheckModels(const fs::path& folder, bool main) {
    const std::map<int, DatasetModelInfo> infos = ReadModelsInfo(folder, Collector());
    for (const auto& [id, info] : infos) {
      const fs::path file = folder / ModelFileName(id);
      const auto mesh = Try([&] { return LoadMesh(file, "mm"); });
      if (mesh) CheckModel(file, *mesh, info, main);
      if (main) known_objects_.insert(id);
    }
    if (main) report_.objects = static_cast<int>(infos.size());
  }

  // Sizes must agree within 1 % of the diameter. A reduced mesh in models_eval keeps the numbers of
  // the original mesh, so its tolerance is 5 %.
  void CheckModel(const fs::path& file, const TriangleMesh& mesh, const DatasetModelInfo& info,
                  bool main) {
    const double allowed_m = (main ? 0.01 : 0.05) * info.diameter_m;
    const double diameter_m = Diameter(mesh);
    if (std::abs(diameter_m - info.diameter_m) > allowed_m) {
      Fault(fmt::format("{}: its diameter is {:.3f} mm, {} says {:.3f}", file.string(),
                        1e3 * diameter_m, kModelsInfoFile, 1e3 * info.diameter_m));
    }
    const Bounds bounds = MeshBounds(mesh);
    const double off_m = std::max((bounds.min - info.bounds_O.min).cwiseAbs().maxCoeff(),
                                  (bounds.max - info.bounds_O.max).cwiseAbs().maxCoeff());
    if (off_m > allowed_m) {
      Fault(fmt::format("{}: its bounding box differs by {:.3f} mm from {}", file.string(),
                        1e3 * off_m, kModelsInfoFile));
    }
  }

  void CheckCameras() {
    bool any = false;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(root_, error)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with("camera") || entry.path().extension() != ".json") continue;
      any = true;
      ReadDatasetCamera(entry.path(), Collector());
    }
    if (!any) Fault((root_ / kDatasetCameraFile).string() + ": is missing");
  }

  void CheckScene(const std::string& split, int scene_id) {
    const fs::path folder = root_ / split / SceneFolderName(scene_id);
    std::vector<std::string> sensors = SensorsOf(folder);
    if (sensors.empty()) sensors.push_back("");  // the reader reports the missing file
    ++report_.scenes;
    for (const std::string& sensor : sensors) {
      const SceneTruth scene = ReadSceneTruth(folder, scene_id, Collector(), sensor);
      for (const std::string& row : scene.unusable) Fault(row);
      for (const auto& [id, image] : scene.images) CheckImage(scene, image);
      CheckStrayFiles(scene);
    }
  }

  void CheckImage(const SceneTruth& scene, const ImageTruth& image) {
    ++report_.images;
    report_.instances += static_cast<int>(image.instances.size());
    const fs::path truth = scene.folder / OfSensor(kSceneTruthFile, scene.sensor);
    std::map<int, int>& counts = instances_[{scene.scene_id, image.image_id}];  // also if empty
    for (size_t i = 0; i < image.instances.size(); ++i) {
      const int object = image.instances[i].object_id;
      ++counts[object];
      if (known_objects_.contains(object)) continue;
      Fault(fmt::format("{}: image {}: instance {}: {} has no object {}", truth.string(),
                        image.image_id, i, kModelsInfoFile, object));
    }
    const auto frame = Try([&] { return ReadFrame(scene, image); });
    if (!frame) return;
    const auto& depth = frame->depth_m.pixels();
    if (std::none_of(depth.begin(), depth.end(), [](float d) { return d > 0; })) {
      Fault(fmt::format("{}: has no depth reading",
                        DepthFile(scene.folder, image.image_id, scene.sensor)->string()));
    }
    CheckInfos(scene, image, frame->depth_m);
    for (const char* kind : {"mask", "mask_visib"}) {
      const std::string folder = OfSensor(kind, scene.sensor);
      if (IsFolder(scene.folder / folder)) CheckMasks(scene, image, folder, frame->depth_m);
    }
  }

  void CheckInfos(const SceneTruth& scene, const ImageTruth& image, const Image<float>& depth_m) {
    for (size_t i = 0; i < image.infos.size(); ++i) {
      const InstanceInfo& info = image.infos[i];
      const auto fault = [&](const std::string& what) {
        Fault(fmt::format("{}: image {}: instance {}: {}",
                          (scene.folder / OfSensor(kSceneTruthInfoFile, scene.sensor)).string(),
                          image.image_id, i, what));
      };
      const double share =
          info.px_count_all > 0 ? static_cast<double>(info.px_count_visib) / info.px_count_all : 0;
      if (std::abs(share - info.visib_fract) > 1e-3) {
        fault(fmt::format("visib_fract is {:.4f}, but {} of {} pixels are {:.4f}", info.visib_fract,
                          info.px_count_visib, info.px_count_all, share));
      }
      if (info.px_count_visib < 0 || info.px_count_visib > info.px_count_all) {
        fault(fmt::format("px_count_visib is {} of {}", info.px_count_visib, info.px_count_all));
      }
      if (info.bbox_obj && info.bbox_visib && !IsInside(*info.bbox_visib, *info.bbox_obj)) {
        fault("bbox_visib is not within bbox_obj");
      }
      if (info.px_count_valid.value_or(0) > static_cast<int>(depth_m.size())) {
        fault(fmt::format("px_count_valid is {}, more than the image has pixels",
                          *info.px_count_valid));
      }
    }
  }

  void CheckMasks(const SceneTruth& scene, const ImageTruth& image, const std::string& kind,
                  const Image<float>& depth_m) {
    for (size_t i = 0; i < image.instances.size(); ++i) {
      const fs::path file = scene.folder / kind / MaskFileName(image.image_id, static_cast<int>(i));
      std::error_code error;
      if (!fs::is_regular_file(file, error)) {
        Fault(file.string() + ": is missing");
        continue;
      }
      const auto mask = Try([&] { return ReadPng8(file); });
      if (!mask) continue;
      if (mask->width() != depth_m.width() || mask->height() != depth_m.height()) {
        Fault(fmt::format("{}: is {} x {} pixels, its depth image {} x {}", file.string(),
                          mask->width(), mask->height(), depth_m.width(), depth_m.height()));
        continue;
      }
      CheckMaskPixels(file, *mask, kind.starts_with("mask_visib") ? &image : nullptr, i);
    }
    const fs::path extra = scene.folder / kind /
                           MaskFileName(image.image_id, static_cast<int>(image.instances.size()));
    std::error_code error;
    if (fs::exists(extra, error)) {
      Fault(fmt::format("{}: {} has only {} instances in this image", extra.string(),
                        kSceneTruthFile, image.instances.size()));
    }
  }

  void CheckMaskPixels(const fs::path& file, const Image<uint8_t>& mask, const ImageTruth* visible,
                       size_t instance) {
    int set = 0, between = 0;
    for (const uint8_t value : mask.pixels()) {
      set += value == 255;
      between += value != 0 && value != 255;
    }
    if (between > 0) {
      Fault(fmt::format("{}: {} pixels are neither 0 nor 255", file.string(), between));
    }
    if (!visible || instance >= visible->infos.size()) return;
    const int given = visible->infos[instance].px_count_visib;
    if (given != set) {
      Fault(fmt::format("{}: has {} pixels, {} says px_count_visib {}", file.string(), set,
                        kSceneTruthInfoFile, given));
    }
  }

  // Reports images without an entry in scene_camera.json.
  void CheckStrayFiles(const SceneTruth& scene) {
    for (const char* kind : {"rgb", "gray", "depth"}) {
      const fs::path folder = scene.folder / OfSensor(kind, scene.sensor);
      std::error_code error;
      std::set<fs::path> strays;
      for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const auto id = ParseId(entry.path().stem().string());
        if (!id || !scene.images.contains(*id)) strays.insert(entry.path());
      }
      for (const fs::path& stray : strays) {
        Fault(fmt::format("{}: {} has no such image", stray.string(), kSceneCameraFile));
      }
    }
  }

  void CheckTargets(const std::string& split, int year) {
    const fs::path file = root_ / TargetsFileName(split, year);
    std::error_code error;
    if (!fs::exists(file, error)) return;
    const std::vector<DatasetTarget> targets = ReadTargets(file, Collector());
    for (size_t i = 0; i < targets.size(); ++i) {
      const DatasetTarget& target = targets[i];
      const auto fault = [&](const std::string& what) {
        Fault(fmt::format("{}: target {}: {}", file.string(), i, what));
      };
      const auto image = instances_.find({target.scene_id, target.image_id});
      if (image == instances_.end()) {
        fault(fmt::format("there is no ground truth for scene {} image {}", target.scene_id,
                          target.image_id));
        continue;
      }
      if (!target.object_id) {
        if (year == 19) fault("has no 'obj_id'");
        continue;
      }
      const auto found = image->second.find(*target.object_id);
      const int there = found == image->second.end() ? 0 : found->second;
      if (target.count.value_or(1) > there) {
        fault(fmt::format("requests {} of object {}, but scene {} image {} has {}",
                          target.count.value_or(1), *target.object_id, target.scene_id,
                          target.image_id, there));
      }
    }
  }

  fs::path root_;
  CheckDatasetReport report_;
  std::set<int> known_objects_;
  // Current split: (scene, image) -> number of instances of each object.
  std::map<std::pair<int, int>, std::map<int, int>> instances_;
};

}  // namespace

CheckDatasetReport CheckDataset(const fs::path& root,
                                const std::function<void(const std::string&)>& on_scene) {
  CheckInput(IsFolder(root), fmt::format("{}: is no folder", root.string()));
  return Checker(root).Run(on_scene);
}

}  // namespace pickbed::eval
