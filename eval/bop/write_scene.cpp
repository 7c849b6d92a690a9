#include "eval/bop/write_scene.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "eval/bop/json.h"
#include "eval/bop/layout.h"
#include "eval/bop/scores.h"
#include "eval/bop/targets.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr int kPngLevel = 1;  // half the time of level 3 for a tenth more bytes

// Writes without a temporary name and without waiting for the disk, because the folder is renamed
// only when it is complete.
void WriteBytes(const fs::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  CheckInput(file.good(), fmt::format("cannot write '{}': {}", path.string(), strerror(errno)));
}

ParsedJson RowsOf(const Eigen::Matrix3d& matrix) {
  ParsedJson numbers = ParsedJson::array();
  for (int i = 0; i < 9; ++i) numbers.push_back(matrix(i / 3, i % 3));
  return numbers;
}

ParsedJson Millimetres(const Eigen::Vector3d& p_m) {
  return {1e3 * p_m.x(), 1e3 * p_m.y(), 1e3 * p_m.z()};
}

ParsedJson CameraJson(const ImageTruth& image) {
  const ImageProjection& k = image.projection;
  ParsedJson camera{{"cam_K", {k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0}},
                    {"depth_scale", image.depth_scale_mm}};
  if (image.X_CW) {
    camera["cam_R_w2c"] = RowsOf(image.X_CW->linear());
    camera["cam_t_w2c"] = Millimetres(image.X_CW->translation());
  }
  return camera;
}

ParsedJson InfoJson(const InstanceInfo& info) {
  return {{"bbox_obj", *info.bbox_obj},
          {"bbox_visib", *info.bbox_visib},
          {"px_count_all", info.px_count_all},
          {"px_count_valid", *info.px_count_valid},
          {"px_count_visib", info.px_count_visib},
          {"visib_fract", info.visib_fract}};
}

// JSON object with one line per image.
std::string Lines(const std::vector<std::pair<int, std::string>>& entries) {
  std::string text = "{\n";
  for (size_t i = 0; i < entries.size(); ++i) {
    text += fmt::format("  \"{}\": {}{}\n", entries[i].first, entries[i].second,
                        i + 1 < entries.size() ? "," : "");
  }
  return text + "}\n";
}

std::string List(const std::vector<std::string>& entries) {
  return fmt::format("[\n    {}\n  ]", fmt::join(entries, ",\n    "));
}

}  // namespace

std::vector<int> RunLengths(const Image<uint8_t>& mask) {
  std::vector<int> runs{0};
  bool set = false;
  for (int x = 0; x < mask.width(); ++x) {
    for (int y = 0; y < mask.height(); ++y) {
      if ((mask(x, y) != 0) != set) {
        set = !set;
        runs.push_back(0);
      }
      ++runs.back();
    }
  }
  return runs;
}

SceneWriter::SceneWriter(fs::path folder, int objects)
    : folder_(std::move(folder)), objects_(objects) {
  for (const char* name : {"rgb", "depth", "mask", "mask_visib"}) MakeFolder(folder_ / name);
}

void SceneWriter::Add(const LabelledImage& image) {
  const int id = image.truth.image_id;
  const std::string name = ImageFileName(id);
  WriteBytes(folder_ / "rgb" / name, EncodePng(image.color, kPngLevel));
  WriteBytes(folder_ / "depth" / name, EncodePng(image.depth, kPngLevel));
  ParsedJson truths = ParsedJson::array(), infos = ParsedJson::array();
  for (size_t i = 0; i < image.masks.size(); ++i) {
    const std::string mask_name = MaskFileName(id, static_cast<int>(i));
    WriteBytes(folder_ / "mask" / mask_name, EncodePng(image.masks[i].mask, kPngLevel));
    WriteBytes(folder_ / "mask_visib" / mask_name, EncodePng(image.masks[i].mask_visib, kPngLevel));
    const DatasetInstance& instance = image.truth.instances[i];
    truths.push_back({{"obj_id", instance.object_id},
                      {"cam_R_m2c", RowsOf(instance.X_CO.linear())},
                      {"cam_t_m2c", Millimetres(instance.X_CO.translation())}});
    infos.push_back(InfoJson(image.masks[i].info));
  }
  cameras_.emplace_back(id, CameraJson(image.truth).dump());
  truths_.emplace_back(id, truths.dump());
  infos_.emplace_back(id, infos.dump());
  AddCoco(image);
}

// Follows the BOP toolkit's calc_gt_coco.py: the box covers the whole silhouette, the mask the
// visible pixels. Instances less than 10 % visible are marked to be ignored. Instances without a
// visible pixel are left out.
void SceneWriter::AddCoco(const LabelledImage& image) {
  const int id = image.truth.image_id;
  coco_images_.push_back(ParsedJson{
      {"id", id},
      {"file_name", "rgb/" + ImageFileName(id)},
      {"width", image.color.width()},
      {"height",
       image.color.height()}}.dump());
  for (size_t i = 0; i < image.masks.size(); ++i) {
    const InstanceMasks& masks = image.masks[i];
    ++annotations_;
    if (masks.info.px_count_visib == 0) continue;
    const ParsedJson segmentation{{"counts", RunLengths(masks.mask_visib)},
                                  {"size", {image.color.height(), image.color.width()}}};
    coco_annotations_.push_back(ParsedJson{
        {"id", annotations_},
        {"image_id", id},
        {"category_id", image.truth.instances[i].object_id},
        {"iscrowd", 0},
        {"area", masks.info.px_count_visib},
        {"bbox", *masks.info.bbox_obj},
        {"segmentation", segmentation},
        {"ignore", masks.info.visib_fract < kMinVisible},
        {"width", image.color.width()},
        {"height",
         image.color.height()}}.dump());
  }
}

void SceneWriter::Finish() {
  WriteBytes(folder_ / kSceneCameraFile, Lines(cameras_));
  WriteBytes(folder_ / kSceneTruthFile, Lines(truths_));
  WriteBytes(folder_ / kSceneTruthInfoFile, Lines(infos_));
  std::vector<std::string> categories;
  for (int id = 1; id <= objects_; ++id) {
    categories.push_back(
        ParsedJson{{"id", id}, {"name", std::to_string(id)}, {"supercategory", "pickbed"}}.dump());
  }
  WriteBytes(folder_ / kSceneCocoFile,
             fmt::format("{{\n  \"info\": {{\"description\": \"pickbed\"}},\n  \"licenses\": [],\n"
                         "  \"categories\": {},\n  \"images\": {},\n  \"annotations\": {}\n}}\n",
                         List(categories), List(coco_images_), List(coco_annotations_)));
}

void WriteTargets(const fs::path& root, const std::string& split) {
  std::vector<std::string> of19, of24;
  for (const int scene_id : SceneIdsOf(root, split)) {
    const SceneTruth scene =
        ReadSceneTruth(root / split / SceneFolderName(scene_id), scene_id, ThrowFault);
    for (const auto& [id, image] : scene.images) {
      std::map<int, int> counts;
      for (size_t i = 0; i < image.infos.size(); ++i) {
        if (image.infos[i].visib_fract >= kMinVisible) ++counts[image.instances[i].object_id];
      }
      for (const auto& [object, count] : counts) {
        of19.push_back(ParsedJson{
            {"scene_id", scene_id}, {"im_id", id}, {"obj_id", object}, {"inst_count", count}}
                           .dump());
      }
      of24.push_back(ParsedJson{{"scene_id", scene_id}, {"im_id", id}}.dump());
    }
  }
  WriteFileAtomically(root / TargetsFileName(split, 19),
                      fmt::format("[\n  {}\n]\n", fmt::join(of19, ",\n  ")));
  WriteFileAtomically(root / TargetsFileName(split, 24),
                      fmt::format("[\n  {}\n]\n", fmt::join(of24, ",\n  ")));
}

}  // namespace pickbed::eval
