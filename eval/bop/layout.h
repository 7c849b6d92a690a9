#pragma once

// File and folder names of a BOP data set in the "BOP-scenewise" layout, as defined in the BOP
// toolkit's docs/bop_datasets_format.md.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

// Files of a data set and, from kSceneCameraFile on, of a scene.
inline constexpr char kDatasetCameraFile[] = "camera.json";
inline constexpr char kModelsInfoFile[] = "models_info.json";  // in the folder of the models
inline constexpr char kCardFile[] = "dataset_card.json";       // only written by pickbed
inline constexpr char kCardTextFile[] = "dataset_card.md";
inline constexpr char kDatasetSettingsFile[] = "dataset_settings.yaml";
inline constexpr char kDatasetScenarioFile[] = "stored_scenario.yaml";  // of the stored scenes
inline constexpr char kSceneCameraFile[] = "scene_camera.json";
inline constexpr char kSceneTruthFile[] = "scene_gt.json";
inline constexpr char kSceneTruthInfoFile[] = "scene_gt_info.json";
inline constexpr char kSceneCocoFile[] = "scene_gt_coco.json";
inline constexpr char kStoredScenesFile[] = "stored_scenes.json";  // only written by pickbed

std::string SceneFolderName(int scene_id);                        // 000001
std::string ImageFileName(int image_id);                          // 000001.png
std::string MaskFileName(int image_id, int position);             // 000001_000000.png
std::string ModelName(int object_id);                             // obj_000001
std::string ModelFileName(int object_id);                         // obj_000001.ply
std::string TargetsFileName(const std::string& split, int year);  // test_targets_bop19.json
std::string MultiViewTargetsFileName(
    const std::string& split);  // test_targets_multiview_bop25.json

// A JSON file of a data set that pickbed writes.
struct DatasetFile {
  std::string name;  // with SPLIT and SCENE in place of their folders
  std::string help;
  ResultColumns keys;
};
// Returns all of them. Most keys are defined by BOP.
std::vector<DatasetFile> DatasetFiles();

// Converts a name that consists only of digits to its number; nullopt for any other name.
std::optional<int> ParseId(const std::string& name);

// Returns the split folders of `root`, sorted: train*, val* and test*, for example train_pbr.
std::vector<std::string> SplitsOf(const std::filesystem::path& root);
// Returns the scene ids of a split, ascending.
std::vector<int> SceneIdsOf(const std::filesystem::path& root, const std::string& split);

// Returns the folder of the models for error computation: models_eval if it exists, else models.
std::filesystem::path EvalModelsFolder(const std::filesystem::path& root);

// Sensors of a data set with several of them have their own files: scene_gt_CAM.json, depth_CAM/.
// The sensor "" has the plain names.
//
// Returns `name` with the sensor before its ending: scene_gt_CAM.json or depth_CAM.
std::string OfSensor(const std::string& name, const std::string& sensor);
// Returns the sensors of a scene folder, sorted, from its scene_camera files.
std::vector<std::string> SensorsOf(const std::filesystem::path& scene);

// Finds the color image in a scene folder: in rgb or gray, as PNG, JPEG or TIFF. Returns nullopt if
// there is none.
std::optional<std::filesystem::path> ColorFile(const std::filesystem::path& scene, int image_id,
                                               const std::string& sensor = "");
// Finds the depth image. Returns nullopt if there is none.
std::optional<std::filesystem::path> DepthFile(const std::filesystem::path& scene, int image_id,
                                               const std::string& sensor = "");

}  // namespace pickbed::eval
