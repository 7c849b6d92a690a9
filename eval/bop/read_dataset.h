#pragma once

// Values of a BOP data set and their readers. The readers convert BOP's millimetres to metres.
// Definitions: the BOP toolkit's docs/bop_datasets_format.md and Hodan et al. 2018.
//
// Each reader takes a handler for faults. ThrowFault throws InputError at the first fault. A
// handler that collects faults lets the reader continue with what it could read; CheckDataset uses
// this.

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "eval/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Receives one line that names the file and the fault in it.
using OnFault = std::function<void(const std::string& line)>;
[[noreturn]] void ThrowFault(const std::string& line);

// An entry of models_info.json.
struct DatasetModelInfo {
  double diameter_m = 0;
  Bounds bounds_O;  // m
  SymmetrySet symmetries_O;
};

// camera.json: the nominal camera of the data set. Each image has its own camera as well.
struct DatasetCamera {
  CameraIntrinsics intrinsics;
  double depth_scale_mm = 1;  // mm per unit of a depth image
};

// An entry of scene_gt_info.json. Boxes are x, y, width, height in px. Values that the file does
// not have are nullopt.
struct InstanceInfo {
  int px_count_all = 0;               // silhouette, also outside the image
  std::optional<int> px_count_valid;  // silhouette inside the image, with a depth reading
  int px_count_visib = 0;
  double visib_fract = 0;  // px_count_visib / px_count_all
  std::optional<std::array<int, 4>> bbox_obj, bbox_visib;
};

// An entry of scene_gt.json.
struct DatasetInstance {
  int object_id = 0;
  // As published: orthonormal only to the digits in the file, but see PublishedRotation().
  Pose X_CO = Pose::Identity();
  bool is_corrected = false;  // the published matrix was replaced by the nearest rotation
  bool is_usable = true;      // false: the published matrix is no rotation, X_CO is the identity
};

// Projection of an image, from an entry of scene_camera.json. The image file defines the size.
struct ImageProjection {
  double fx = 1, fy = 1, cx = 0, cy = 0;  // px
  CameraIntrinsics ForSize(int width, int height) const { return {width, height, fx, fy, cx, cy}; }
};

struct ImageTruth {
  int image_id = 0;
  ImageProjection projection;
  double depth_scale_mm = 1;
  std::optional<Pose> X_CW;
  std::vector<DatasetInstance> instances;
  std::vector<InstanceInfo> infos;  // one per instance; empty without scene_gt_info.json
};

struct SceneTruth {
  int scene_id = 0;
  std::filesystem::path folder;
  std::map<int, ImageTruth> images;
  std::string sensor = {};                 // whose files were read; empty = the plain file names
  std::vector<std::string> unusable = {};  // place and reason for each instance without a rotation
};

// One view of a multi-view target.
struct TargetView {
  std::string sensor;  // empty for BOP's "default"
  int image_id = 0;
};

// An entry of a targets file. BOP24 entries name only the image. A multi-view entry has all its
// views, and the first one as its image.
struct DatasetTarget {
  int scene_id = 0;
  int image_id = 0;
  std::optional<int> object_id;
  std::optional<int> count;
  std::vector<TargetView> views = {};
};

// Reads models_info.json in `folder`, by obj_id. The readers below report every fault to `fault`.
std::map<int, DatasetModelInfo> ReadModelsInfo(const std::filesystem::path& folder,
                                               const OnFault& fault);
// Reads camera.json of a dataset: intrinsics (px) and the scale of depth images (mm).
std::optional<DatasetCamera> ReadDatasetCamera(const std::filesystem::path& file,
                                               const OnFault& fault);
// Reads scene_camera.json, scene_gt.json and scene_gt_info.json of a scene folder, or the files of
// a sensor such as scene_gt_CAM.json. Without `sensor`, it reads the plain files, or the files of
// the only sensor. Throws InputError if the sensor does not exist, or has to be chosen.
SceneTruth ReadSceneTruth(const std::filesystem::path& folder, int scene_id, const OnFault& fault,
                          const std::string& sensor = "");
// Reads a targets file, also one with several views per target.
std::vector<DatasetTarget> ReadTargets(const std::filesystem::path& file, const OnFault& fault);

// Loads an object with its mesh in `folder`. BOP states no mass and friction, so mass (0.1 kg) and
// friction have fixed values. Throws InputError.
std::shared_ptr<const ObjectModel> LoadDatasetModel(const std::filesystem::path& folder,
                                                    int object_id, const DatasetModelInfo& info,
                                                    const std::string& name);

// Reads color and depth of an image. The intrinsics get the size of the depth image. Throws
// InputError if a file is missing, depth is not 16 bits, or the sizes differ.
RgbdFrame ReadFrame(const SceneTruth& scene, const ImageTruth& image);
// Same as ReadFrame, without color.
RgbdFrame ReadDepthFrame(const SceneTruth& scene, const ImageTruth& image);

// Returns width and height of each camera*.json of a data set; px. Throws InputError for one with a
// fault.
std::vector<std::pair<int, int>> CameraSizes(const std::filesystem::path& root);
// Throws InputError if no camera has the size of the depth image, and the color image does not
// have it either.
void CheckImageSize(const SceneTruth& scene, const ImageTruth& image, const RgbdFrame& frame,
                    const std::vector<std::pair<int, int>>& camera_sizes);

// Returns why a matrix is not a rotation; empty if it is one. Published matrices are rounded or
// come from optimisation, so entries of R^T R may deviate from the identity by up to 0.05.
std::string RotationFault(const Eigen::Matrix3d& R);
// Returns R if its deviation is rounding, at most 0.005; otherwise the nearest rotation.
Eigen::Matrix3d PublishedRotation(const Eigen::Matrix3d& R);

}  // namespace pickbed::eval
