#include "eval/bop/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> FirstOf(const fs::path& scene, std::initializer_list<const char*> folders,
                                std::initializer_list<const char*> endings, int image_id,
                                const std::string& sensor) {
  std::error_code error;
  for (const char* folder : folders) {
    for (const char* ending : endings) {
      const fs::path path =
          scene / OfSensor(folder, sensor) / fmt::format("{:06}.{}", image_id, ending);
      if (fs::is_regular_file(path, error)) return path;
    }
  }
  return std::nullopt;
}

}  // namespace

std::string SceneFolderName(int scene_id) { return fmt::format("{:06}", scene_id); }
std::string ImageFileName(int image_id) { return fmt::format("{:06}.png", image_id); }
std::string MaskFileName(int image_id, int position) {
  return fmt::format("{:06}_{:06}.png", image_id, position);
}
std::string ModelName(int object_id) { return fmt::format("obj_{:06}", object_id); }
std::string ModelFileName(int object_id) { return ModelName(object_id) + ".ply"; }
std::string TargetsFileName(const std::string& split, int year) {
  return fmt::format("{}_targets_bop{}.json", split, year);
}
std::string MultiViewTargetsFileName(const std::string& split) {
  return split + "_targets_multiview_bop25.json";
}

std::vector<DatasetFile> DatasetFiles() {
  const std::string scene = "SPLIT/SCENE/", coco = "annotations[].";
  return {
      {kCardFile,
       "what the data set was made from",
       {{"format", "layout of the data set"},
        {"seed", "random seed"},
        {"views", "number of images per scene; 0 = one per attempt of a run"},
        {"split", "name of the folder with the scenes"},
        {"settings", "scenario, sensor and meshes as text"},
        {"objects[].obj_id", "number of the object"},
        {"objects[].name", "name of the object"},
        {"objects[].mesh", "hash of its mesh"},
        {"scenes", "number of scenes"},
        {"scene_hashes.SCENE", "hash of the files of a scene"},
        {"models", "hash of the files in models/"},
        {"hash", "hash of all scenes"}}},
      {kDatasetCameraFile,
       "camera of all images",
       {{"cx", "principal point, x", "px"},
        {"cy", "principal point, y", "px"},
        {"fx", "focal length, x", "px"},
        {"fy", "focal length, y", "px"},
        {"width", "image width", "px"},
        {"height", "image height", "px"},
        {"depth_scale", "depth for one unit of a depth image", "mm"}}},
      {std::string("models/") + kModelsInfoFile,
       "objects, by obj_id; models_eval/ has the same file",
       {{"ID.diameter", "largest distance of two vertices", "mm"},
        {"ID.min_x", "smallest x of a vertex", "mm"},
        {"ID.min_y", "smallest y of a vertex", "mm"},
        {"ID.min_z", "smallest z of a vertex", "mm"},
        {"ID.size_x", "extent of the vertices along x", "mm"},
        {"ID.size_y", "extent of the vertices along y", "mm"},
        {"ID.size_z", "extent of the vertices along z", "mm"},
        {"ID.name", "name of the object in pickbed"},
        {"ID.symmetries_discrete", "symmetric poses, 4x4 matrices row by row", "mm"},
        {"ID.symmetries_continuous[].axis", "direction of an axis of rotational symmetry"},
        {"ID.symmetries_continuous[].offset", "point on the axis", "mm"}}},
      {scene + kSceneCameraFile,
       "camera, by image",
       {{"ID.cam_K", "camera matrix, row by row", "px"},
        {"ID.depth_scale", "depth for one unit of the depth image", "mm"},
        {"ID.cam_R_w2c", "rotation from the world frame to the camera frame, row by row"},
        {"ID.cam_t_w2c", "origin of the world frame in the camera frame", "mm"}}},
      {scene + kSceneTruthFile,
       "poses, by image; one entry per instance",
       {{"ID[].obj_id", "number of the object"},
        {"ID[].cam_R_m2c", "rotation from the object frame to the camera frame, row by row"},
        {"ID[].cam_t_m2c", "origin of the object frame in the camera frame", "mm"}}},
      {scene + kSceneTruthInfoFile,
       "visibility, by image; one entry per instance",
       {{"ID[].bbox_obj", "box of the silhouette: x, y, width, height", "px"},
        {"ID[].bbox_visib", "box of the visible part", "px"},
        {"ID[].px_count_all", "number of pixels of the silhouette"},
        {"ID[].px_count_valid", "number of these pixels with a depth reading"},
        {"ID[].px_count_visib", "number of visible pixels"},
        {"ID[].visib_fract", "visible fraction", "0..1"}}},
      {scene + kSceneCocoFile,
       "visible masks in the COCO format",
       {{"info.description", "name of the program"},
        {"licenses", "empty"},
        {"categories[].id", "number of the object"},
        {"categories[].name", "its name"},
        {"categories[].supercategory", "name of the program"},
        {"images[].id", "number of the image"},
        {"images[].file_name", "file of the image"},
        {"images[].width", "image width", "px"},
        {"images[].height", "image height", "px"},
        {coco + "id", "number of the annotation"},
        {coco + "image_id", "number of the image"},
        {coco + "category_id", "number of the object"},
        {coco + "iscrowd", "0"},
        {coco + "area", "number of visible pixels"},
        {coco + "bbox", "box of the silhouette: x, y, width, height", "px"},
        {coco + "segmentation.counts", "run lengths of the mask, column by column"},
        {coco + "segmentation.size", "image height and width", "px"},
        {coco + "ignore", "whether under a tenth of the instance is visible"},
        {coco + "width", "image width", "px"},
        {coco + "height", "image height", "px"}}},
      {scene + kStoredScenesFile,
       "the scenes that the images show, to continue their physics",
       {{"format", "version of this file"},
        {"seed", "random seed"},
        {"bin_index", "number of the bin"},
        {"bin.inner_size_m", "inner length, width and height of the bin"},
        {"bin.wall_m", "thickness of walls and floor"},
        {"bin.friction", "coefficient of friction of the bin"},
        {"objects[].obj_id", "number of the object"},
        {"objects[].name", "name of the object"},
        {"objects[].mesh", "hash of its mesh"},
        {"objects[].mass_kg", "mass of the object"},
        {"objects[].friction", "coefficient of friction of the object"},
        {"objects[].size_deviation", "deviation of the size in this bin, as a share"},
        {"images.ID", "index of the scene that the image shows"},
        {"scenes[].instances[].instance", "number of the instance"},
        {"scenes[].instances[].obj_id", "number of its object"},
        {"scenes[].instances[].R", "rotation from the object frame to the world frame, row by row"},
        {"scenes[].instances[].t_m", "origin of the object frame in the world frame"},
        {"scenes[].instances[].friction_deviation", "deviation of the friction, as a share"},
        {"scenes[].instances[].mass_deviation", "deviation of the mass, as a share"}}},
      {"SPLIT_targets_bop19.json",
       "targets of 6D localisation",
       {{"[].scene_id", "number of the scene"},
        {"[].im_id", "number of the image"},
        {"[].obj_id", "number of the object"},
        {"[].inst_count", "number of its instances that are at least 10 % visible"}}},
      {"SPLIT_targets_bop24.json",
       "targets of 6D detection",
       {{"[].scene_id", "number of the scene"}, {"[].im_id", "number of the image"}}},
  };
}

std::optional<int> ParseId(const std::string& name) {
  int id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  const bool digits = !name.empty() && name[0] != '-' && end == name.data() + name.size();
  return digits && error == std::errc() ? std::optional(id) : std::nullopt;
}

std::vector<std::string> SplitsOf(const fs::path& root) {
  constexpr std::array<std::string_view, 3> kKinds{"train", "val", "test"};
  std::vector<std::string> splits;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root, error)) {
    const std::string name = entry.path().filename().string();
    const std::string kind = name.substr(0, name.find('_'));
    const bool known = std::find(kKinds.begin(), kKinds.end(), kind) != kKinds.end();
    if (entry.is_directory(error) && known) splits.push_back(name);
  }
  std::sort(splits.begin(), splits.end());
  return splits;
}

std::vector<int> SceneIdsOf(const fs::path& root, const std::string& split) {
  std::vector<int> scenes;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root / split, error)) {
    const std::optional<int> id = ParseId(entry.path().filename().string());
    if (id && entry.is_directory(error)) scenes.push_back(*id);
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

fs::path EvalModelsFolder(const fs::path& root) {
  std::error_code error;
  const fs::path reduced = root / "models_eval";
  return fs::is_directory(reduced, error) ? reduced : root / "models";
}

std::string OfSensor(const std::string& name, const std::string& sensor) {
  if (sensor.empty()) return name;
  const size_t dot = std::min(name.find('.'), name.size());
  return name.substr(0, dot) + "_" + sensor + name.substr(dot);
}

std::vector<std::string> SensorsOf(const fs::path& scene) {
  const std::string head = fs::path(kSceneCameraFile).stem().string();
  std::vector<std::string> sensors;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(scene, error)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".json" || !name.starts_with(head)) continue;
    if (name == head) sensors.push_back("");
    if (name.starts_with(head + "_")) sensors.push_back(name.substr(head.size() + 1));
  }
  std::sort(sensors.begin(), sensors.end());
  return sensors;
}

std::optional<fs::path> ColorFile(const fs::path& scene, int image_id, const std::string& sensor) {
  return FirstOf(scene, {"rgb", "gray"}, {"png", "jpg", "tif"}, image_id, sensor);
}

std::optional<fs::path> DepthFile(const fs::path& scene, int image_id, const std::string& sensor) {
  return FirstOf(scene, {"depth"}, {"png", "tif"}, image_id, sensor);
}

}  // namespace pickbed::eval
