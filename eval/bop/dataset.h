#pragma once

// A BOP data set as values, and its readers. BOP's millimetres end here: everything below is in
// metres. Definitions: the BOP toolkit's docs/bop_datasets_format.md and Hodan et al. 2018.
//
// Every reader takes what to do with a fault: ThrowFault ends with an InputError at the first one;
// a collector goes on with what could be read, which is how a data set is checked.

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenes/camera.h"
#include "scenes/object_model.h"
#include "scenes/rgbd_frame.h"
#include "scenes/triangle_mesh.h"

namespace pickbed::bop {

// One line that names the file and what is wrong in it.
using OnFault = std::function<void(const std::string& line)>;
[[noreturn]] void ThrowFault(const std::string& line);

// An entry of models_info.json.
struct ModelInfo {
  double diameter_m = 0;
  Bounds bounds_O;  // m
  SymmetrySet symmetries_O;
};

// camera.json: what the data set was made for. Each image has a camera of its own.
struct DatasetCamera {
  CameraIntrinsics intrinsics;
  double depth_scale_mm = 1;  // mm in one unit of a depth image
};

// An entry of scene_gt_info.json. Boxes are x, y, width, height in px; what a file does not state
// is nothing.
struct InstanceInfo {
  int px_count_all = 0;               // of the silhouette, also outside the image
  std::optional<int> px_count_valid;  // of the silhouette in the image with a depth reading
  int px_count_visib = 0;
  double visib_fract = 0;  // px_count_visib / px_count_all
  std::optional<std::array<int, 4>> bbox_obj, bbox_visib;
};

// An entry of scene_gt.json.
struct Instance {
  int object_id = 0;
  Pose X_CO = Pose::Identity();  // as published: orthonormal to the digits of the file only
};

struct ImageTruth {
  int image_id = 0;
  CameraIntrinsics intrinsics;  // width and height are 0: the image file knows them
  double depth_scale_mm = 1;
  std::optional<Pose> X_CW;
  std::vector<Instance> instances;
  std::vector<InstanceInfo> infos;  // of each instance; empty where there is no scene_gt_info.json
};

struct SceneTruth {
  int scene_id = 0;
  std::filesystem::path folder;
  std::map<int, ImageTruth> images;
};

// An entry of a targets file. BOP24's name the image alone.
struct Target {
  int scene_id = 0;
  int image_id = 0;
  std::optional<int> object_id;
  std::optional<int> count;
};

std::map<int, ModelInfo> ReadModelsInfo(const std::filesystem::path& folder, const OnFault& fault);
std::optional<DatasetCamera> ReadDatasetCamera(const std::filesystem::path& file,
                                               const OnFault& fault);
SceneTruth ReadSceneTruth(const std::filesystem::path& folder, int scene_id, const OnFault& fault);
std::vector<Target> ReadTargets(const std::filesystem::path& file, const OnFault& fault);

// The part of an id with its mesh of `folder`; mass and friction are those of a light plastic,
// which BOP does not know. Throws InputError.
std::shared_ptr<const ObjectModel> LoadModel(const std::filesystem::path& folder, int object_id,
                                             const ModelInfo& info, const std::string& name);

// Colour and depth of an image; intrinsics with the size of its depth. Throws InputError when a
// file is missing, depth is not 16 bits, or their sizes differ.
RgbdFrame ReadFrame(const SceneTruth& scene, const ImageTruth& image);
// The same without colour.
RgbdFrame ReadDepthFrame(const SceneTruth& scene, const ImageTruth& image);

// What is wrong with a matrix that should be a rotation; empty when nothing is. Published ones are
// rounded, so that entries of R^T R may be off by up to 0.005.
std::string RotationFault(const Eigen::Matrix3d& R);

}  // namespace pickbed::bop
