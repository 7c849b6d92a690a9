#include "eval/bop/read_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include "eval/bop/json.h"
#include "eval/bop/layout.h"
#include "scenes/base/error.h"
#include "scenes/image/image_io.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr double kMm = 1e-3;

// Limits of plausible values. Distances of a camera are above the first, also in microscopy.
constexpr double kMinDistance_mm = 0.1;
constexpr double kMinDepthScale_mm = 1e-6, kMaxDepthScale_mm = 100;  // 100: a reading up to 6.5 km
constexpr double kMaxDiameter_mm = 1e6;
constexpr double kMaxBox_px = 1e6;

// Visits every member of a JSON object whose keys are ids, such as `{"3": ...}`.
template <typename Take>
void ForEachId(const ParsedJson& object, const JsonPlace& place, const char* what, Take take) {
  if (!object.is_object()) {
    place.Fault("is not an object with an entry for each " + std::string(what));
    return;
  }
  for (const auto& [key, value] : object.items()) {
    if (const std::optional<int> id = ParseId(key)) {
      take(*id, value, place / fmt::format("{} {}", what, *id));
    } else {
      place.Fault(fmt::format("'{}' is not the number of an {}", key, what));
    }
  }
}

// Largest deviation of R^T R from the identity.
double DeviationOf(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

std::optional<Pose> ToPose(const Eigen::Matrix3d& R, const std::vector<double>& t_mm,
                           const JsonPlace& place) {
  if (const std::string wrong = RotationFault(R); !wrong.empty()) {
    place.Fault(wrong);
    return std::nullopt;
  }
  return MakePose(PublishedRotation(R), kMm * Eigen::Vector3d(t_mm[0], t_mm[1], t_mm[2]));
}

// Reads a rotation and a translation in mm under two keys.
std::optional<Pose> ReadPose(const ParsedJson& object, const char* R_key, const char* t_key,
                             const JsonPlace& place) {
  const auto R = JsonReals(object, R_key, 9, place);
  const auto t_mm = JsonReals(object, t_key, 3, place);
  if (!R || !t_mm) return std::nullopt;
  return ToPose(ToMatrix3(*R), *t_mm, place / fmt::format("'{}'", R_key));
}

void ReadSymmetries(const ParsedJson& entry, const JsonPlace& place, SymmetrySet& symmetries_O) {
  for (const ParsedJson& matrix : entry.value("symmetries_discrete", ParsedJson::array())) {
    const JsonPlace where = place / "'symmetries_discrete'";
    const auto n = ToReals(matrix, 16, where);
    if (!n) continue;
    const std::vector<double>& m = *n;
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) {
      where.Fault("the last row of a 4x4 matrix is not 0 0 0 1");
      continue;
    }
    const Eigen::Matrix3d R = ToMatrix3({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    if (const auto X = ToPose(R, {m[3], m[7], m[11]}, where)) symmetries_O.discrete_O.push_back(*X);
  }
  for (const ParsedJson& axis : entry.value("symmetries_continuous", ParsedJson::array())) {
    const JsonPlace where = place / "'symmetries_continuous'";
    const auto direction = JsonReals(axis, "axis", 3, where);
    const auto offset_mm = JsonReals(axis, "offset", 3, where);
    if (!direction || !offset_mm) continue;
    const Eigen::Vector3d along_O = Eigen::Vector3d::Map(direction->data());
    if (along_O.norm() < 1e-9) {
      where.Fault("an axis has no length");
      continue;
    }
    symmetries_O.continuous_O.push_back(
        {along_O.normalized(), kMm * Eigen::Vector3d::Map(offset_mm->data())});
  }
}

std::optional<DatasetModelInfo> ReadModelInfo(const ParsedJson& entry, const JsonPlace& place) {
  DatasetModelInfo info;
  const auto diameter_mm = JsonReal(entry, "diameter", place);
  if (!diameter_mm) return std::nullopt;
  if (*diameter_mm <= 0 || *diameter_mm > kMaxDiameter_mm) {
    place.Fault(fmt::format("'diameter' is {}, not positive and at most {:g}", *diameter_mm,
                            kMaxDiameter_mm));
  }
  info.diameter_m = kMm * *diameter_mm;
  constexpr const char* kMin[] = {"min_x", "min_y", "min_z"};
  constexpr const char* kSize[] = {"size_x", "size_y", "size_z"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto low_mm = JsonReal(entry, kMin[axis], place),
               size_mm = JsonReal(entry, kSize[axis], place);
    if (!low_mm || !size_mm) continue;
    info.bounds_O.min[axis] = kMm * *low_mm;
    info.bounds_O.max[axis] = kMm * (*low_mm + *size_mm);
  }
  ReadSymmetries(entry, place, info.symmetries_O);
  return info;
}

void CheckDepthScale(double scale_mm, const JsonPlace& place) {
  if (scale_mm >= kMinDepthScale_mm && scale_mm <= kMaxDepthScale_mm) return;
  place.Fault(fmt::format("'depth_scale' is {}, not from {:g} to {:g}", scale_mm, kMinDepthScale_mm,
                          kMaxDepthScale_mm));
}

void ReadCamera(const ParsedJson& entry, const JsonPlace& place, ImageTruth& image) {
  const auto K = JsonReals(entry, "cam_K", 9, place);
  if (K) {
    const std::vector<double>& k = *K;
    const std::string faults = CameraIntrinsics::FaultsOf(1, 1, k[0], k[4], k[2], k[5]);
    if (faults.empty()) {
      image.projection = {k[0], k[4], k[2], k[5]};
    } else {
      place.Fault("'cam_K': " + faults);
    }
    if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
      place.Fault("'cam_K' is not fx 0 cx 0 fy cy 0 0 1");
    }
  }
  if (entry.is_object() && entry.contains("depth_scale")) {
    image.depth_scale_mm = JsonReal(entry, "depth_scale", place).value_or(1);
    CheckDepthScale(image.depth_scale_mm, place);
  }
  if (entry.is_object() && entry.contains("cam_R_w2c")) {
    image.X_CW = ReadPose(entry, "cam_R_w2c", "cam_t_w2c", place);
  } else if (entry.is_object() && entry.contains("cam_t_w2c")) {
    place.Fault("'cam_t_w2c' is given without 'cam_R_w2c'; give both or none");
  }
}

std::optional<std::array<int, 4>> ReadBox(const ParsedJson& entry, const char* key,
                                          const JsonPlace& place) {
  if (!entry.is_object() || !entry.contains(key)) return std::nullopt;
  const auto numbers = JsonReals(entry, key, 4, place);
  if (!numbers) return std::nullopt;
  for (const double number : *numbers) {
    if (std::abs(number) <= kMaxBox_px) continue;
    place.Fault(fmt::format("'{}' has {}, beyond {:g} px", key, number, kMaxBox_px));
    return std::nullopt;
  }
  std::array<int, 4> box;
  for (int i = 0; i < 4; ++i) box[i] = static_cast<int>(std::lround((*numbers)[i]));
  return box;
}

InstanceInfo ReadInfo(const ParsedJson& entry, const JsonPlace& place) {
  InstanceInfo info;
  info.px_count_all = JsonInteger(entry, "px_count_all", place).value_or(0);
  info.px_count_visib = JsonInteger(entry, "px_count_visib", place).value_or(0);
  info.visib_fract = JsonReal(entry, "visib_fract", place).value_or(0);
  if (entry.is_object() && entry.contains("px_count_valid")) {
    info.px_count_valid = JsonInteger(entry, "px_count_valid", place);
  }
  info.bbox_obj = ReadBox(entry, "bbox_obj", place);
  info.bbox_visib = ReadBox(entry, "bbox_visib", place);
  return info;
}

// Keys that a file of another program need not have. If one instance has it, all must.
class OptionalKeys {
 public:
  void Add(const ParsedJson& entry, const JsonPlace& place) {
    for (Key& key : keys_) {
      const bool has = entry.is_object() && entry.contains(key.name);
      key.is_used |= has;
      if (!has) key.missing.push_back(place);
    }
  }
  void Report() const {
    for (const Key& key : keys_) {
      if (!key.is_used) continue;
      for (const JsonPlace& place : key.missing) {
        place.Fault(fmt::format("has no '{}', but other instances have one", key.name));
      }
    }
  }

 private:
  struct Key {
    const char* name;
    bool is_used = false;
    std::vector<JsonPlace> missing = {};
  };
  std::array<Key, 3> keys_{Key{"px_count_valid"}, Key{"bbox_obj"}, Key{"bbox_visib"}};
};

// A matrix that is no rotation makes only its instance unusable, so that one bad row does not stop
// the work on a large dataset.
void ReadInstances(const ParsedJson& list, const JsonPlace& place, SceneTruth& scene,
                   ImageTruth& image) {
  if (!list.is_array()) return place.Fault("is not a list of instances");
  for (size_t i = 0; i < list.size(); ++i) {
    const JsonPlace where = place / fmt::format("instance {}", i);
    DatasetInstance instance;
    instance.object_id = JsonInteger(list[i], "obj_id", where).value_or(0);
    const auto entries = JsonReals(list[i], "cam_R_m2c", 9, where);
    const auto t_mm = JsonReals(list[i], "cam_t_m2c", 3, where);
    if (entries && t_mm) {
      const Eigen::Matrix3d R = ToMatrix3(*entries), published = PublishedRotation(R);
      if (const std::string wrong = RotationFault(R); !wrong.empty()) {
        instance.is_usable = false;
        scene.unusable.push_back((where / "'cam_R_m2c'").text() + ": " + wrong);
      } else {
        instance.is_corrected = published != R;
        instance.X_CO = MakePose(published, kMm * Eigen::Vector3d::Map(t_mm->data()));
      }
      const double distance_mm = (*t_mm)[2];
      if (distance_mm <= 0) {
        where.Fault("is behind the camera");
      } else if (distance_mm < kMinDistance_mm) {
        where.Fault(
            fmt::format("is {} mm from the camera, not {} or more", distance_mm, kMinDistance_mm));
      }
    }
    image.instances.push_back(instance);
  }
}

// Visits the entry of each image in a file. An entry without an image in the scene is a fault, and
// an image without an entry too.
template <typename Take>
void ForEachImage(const fs::path& file, SceneTruth& scene, const OnFault& fault, Take take) {
  const std::optional<ParsedJson> json = ReadJson(file, fault);
  if (!json) return;
  const JsonPlace place(file.string(), fault);
  ForEachId(*json, place, "image", [&](int id, const ParsedJson& entry, const JsonPlace& where) {
    const auto image = scene.images.find(id);
    if (image == scene.images.end()) {
      return where.Fault(fmt::format("{} has no such image", kSceneCameraFile));
    }
    take(image->second, entry, where);
  });
  for (const auto& [id, image] : scene.images) {
    if (json->is_object() && !json->contains(std::to_string(id))) {
      place.Fault(fmt::format("has no entry for image {}", id));
    }
  }
}

// Returns the sensor whose files are read. Throws InputError if it has to be chosen.
std::string ChosenSensor(const fs::path& folder, const std::string& wanted) {
  const std::vector<std::string> sensors = SensorsOf(folder);
  const auto has = [&](const std::string& sensor) {
    return std::ranges::find(sensors, sensor) != sensors.end();
  };
  if (!wanted.empty()) {
    std::vector<std::string> named = sensors;
    std::erase(named, "");
    CheckInput(has(wanted),
               fmt::format("{}: has no files of a sensor {}; it has {}", folder.string(), wanted,
                           named.empty() ? "only the plain file names"
                                         : fmt::format("{}", fmt::join(named, ", "))));
    return wanted;
  }
  if (sensors.empty() || has("")) return "";  // the reader reports a missing file
  CheckInput(sensors.size() == 1, fmt::format("{}: has the sensors {}; choose a camera",
                                              folder.string(), fmt::join(sensors, ", ")));
  return sensors.front();
}

// Reads [["default", 1490], ["left", 3]], the views of a multi-view target.
std::vector<TargetView> ReadViews(const ParsedJson& list, const JsonPlace& place) {
  std::vector<TargetView> views;
  for (const ParsedJson& view : list) {
    if (!view.is_array() || view.size() != 2 || !view[0].is_string() ||
        !view[1].is_number_integer() || view[1] < 0 || view[1] > kLargestNumber) {
      place.Fault("'im_id' is no list of [sensor, number]");
      return {};
    }
    const std::string sensor = view[0].get<std::string>();
    views.push_back({sensor == "default" ? "" : sensor, view[1].get<int>()});
  }
  if (views.empty()) place.Fault("'im_id' is an empty list");
  return views;
}

}  // namespace

std::string RotationFault(const Eigen::Matrix3d& R) {
  constexpr double kLargest = 0.05;
  if (!R.allFinite()) return "is no rotation: a value is not finite";
  const double deviation = DeviationOf(R);
  if (deviation > kLargest)
    return fmt::format("is no rotation: R^T R differs from the identity by {:.2g}", deviation);
  if (R.determinant() < 0) return "is no rotation but a reflection: its determinant is -1";
  return "";
}

Eigen::Matrix3d PublishedRotation(const Eigen::Matrix3d& R) {
  constexpr double kRounding = 5e-3;
  return DeviationOf(R) > kRounding ? Orthonormalized(R) : R;
}

std::map<int, DatasetModelInfo> ReadModelsInfo(const fs::path& folder, const OnFault& fault) {
  std::map<int, DatasetModelInfo> models;
  const fs::path file = folder / kModelsInfoFile;
  const std::optional<ParsedJson> json = ReadJson(file, fault);
  if (!json) return models;
  ForEachId(*json, JsonPlace(file.string(), fault), "object",
            [&](int id, const ParsedJson& entry, const JsonPlace& place) {
              if (const auto info = ReadModelInfo(entry, place)) models[id] = *info;
            });
  if (models.empty()) fault(file.string() + ": names no object");
  return models;
}

std::optional<DatasetCamera> ReadDatasetCamera(const fs::path& file, const OnFault& fault) {
  const std::optional<ParsedJson> json = ReadJson(file, fault);
  if (!json) return std::nullopt;
  const JsonPlace place(file.string(), fault);
  const auto width = JsonInteger(*json, "width", place),
             height = JsonInteger(*json, "height", place);
  const auto fx = JsonReal(*json, "fx", place), fy = JsonReal(*json, "fy", place);
  const auto cx = JsonReal(*json, "cx", place), cy = JsonReal(*json, "cy", place);
  const auto depth_scale_mm = JsonReal(*json, "depth_scale", place);
  if (depth_scale_mm) CheckDepthScale(*depth_scale_mm, place);
  if (!width || !height || !fx || !fy || !cx || !cy || !depth_scale_mm) return std::nullopt;
  std::string faults = CameraIntrinsics::FaultsOf(*width, *height, *fx, *fy, *cx, *cy);
  if (faults.empty() && !(*cx > -0.5 && *cy > -0.5 && *cx < *width && *cy < *height)) {
    faults = fmt::format("the principal point ({}, {}) is outside of the image", *cx, *cy);
  }
  if (!faults.empty()) {
    place.Fault(faults);
    return std::nullopt;
  }
  return DatasetCamera{{*width, *height, *fx, *fy, *cx, *cy}, *depth_scale_mm};
}

SceneTruth ReadSceneTruth(const fs::path& folder, int scene_id, const OnFault& fault,
                          const std::string& wanted_sensor) {
  const std::string sensor = ChosenSensor(folder, wanted_sensor);
  SceneTruth scene{scene_id, folder, {}, sensor};
  const fs::path cameras = folder / OfSensor(kSceneCameraFile, sensor);
  const bool has_depth = fs::is_directory(folder / OfSensor("depth", sensor));
  if (const std::optional<ParsedJson> json = ReadJson(cameras, fault)) {
    const bool has_scales = std::ranges::any_of(*json, [](const ParsedJson& entry) {
      return entry.is_object() && entry.contains("depth_scale");
    });
    ForEachId(
        *json, JsonPlace(cameras.string(), fault), "image",
        [&](int id, const ParsedJson& entry, const JsonPlace& place) {
          scene.images[id].image_id = id;
          ReadCamera(entry, place, scene.images[id]);
          if ((has_depth || has_scales) && entry.is_object() && !entry.contains("depth_scale")) {
            place.Fault(
                "has no 'depth_scale', but the scene has depth images or other images have one");
          }
        });
  }
  if (scene.images.empty()) return scene;
  ForEachImage(folder / OfSensor(kSceneTruthFile, sensor), scene, fault,
               [&](ImageTruth& image, const ParsedJson& entry, const JsonPlace& place) {
                 ReadInstances(entry, place, scene, image);
               });
  OptionalKeys optional_keys;
  ForEachImage(folder / OfSensor(kSceneTruthInfoFile, sensor), scene, fault,
               [&](ImageTruth& image, const ParsedJson& entry, const JsonPlace& place) {
                 if (!entry.is_array()) return place.Fault("is not a list of instances");
                 for (size_t i = 0; i < entry.size(); ++i) {
                   const JsonPlace where = place / fmt::format("instance {}", i);
                   image.infos.push_back(ReadInfo(entry[i], where));
                   optional_keys.Add(entry[i], where);
                 }
                 if (image.infos.size() == image.instances.size()) return;
                 place.Fault(fmt::format("has {} instances, {} has {}", image.infos.size(),
                                         kSceneTruthFile, image.instances.size()));
                 image.infos.resize(image.instances.size());
               });
  optional_keys.Report();
  return scene;
}

std::vector<DatasetTarget> ReadTargets(const fs::path& file, const OnFault& fault) {
  std::vector<DatasetTarget> targets;
  const std::optional<ParsedJson> json = ReadJson(file, fault);
  if (!json) return targets;
  std::set<std::tuple<int, int, int>> listed;  // scene, image, object
  const JsonPlace place(file.string(), fault);
  if (!json->is_array()) {
    place.Fault("is not a list of targets");
    return targets;
  }
  for (size_t i = 0; i < json->size(); ++i) {
    const ParsedJson& entry = (*json)[i];
    const JsonPlace where = place / fmt::format("target {}", i);
    const auto scene_id = JsonInteger(entry, "scene_id", where);
    DatasetTarget target;
    if (entry.is_object() && entry.contains("im_id") && entry["im_id"].is_array()) {
      target.views = ReadViews(entry["im_id"], where);
      if (target.views.empty()) continue;
      target.image_id = target.views.front().image_id;
    } else {
      const auto image_id = JsonInteger(entry, "im_id", where);
      if (!image_id) continue;
      target.image_id = *image_id;
    }
    if (!scene_id) continue;
    target.scene_id = *scene_id;
    if (entry.contains("obj_id")) target.object_id = JsonInteger(entry, "obj_id", where);
    if (entry.contains("inst_count")) target.count = JsonInteger(entry, "inst_count", where);
    if (target.count.value_or(1) < 1) where.Fault("'inst_count' is less than 1");
    const bool is_new =
        !target.views.empty() ||
        listed.insert({target.scene_id, target.image_id, target.object_id.value_or(-1)}).second;
    if (!is_new) where.Fault("is listed before: the same scene, image and object");
    targets.push_back(target);
  }
  return targets;
}

std::shared_ptr<const ObjectModel> LoadDatasetModel(const fs::path& folder, int object_id,
                                                    const DatasetModelInfo& info,
                                                    const std::string& name) {
  constexpr double kAnyMass_kg = 0.1;  // arbitrary: no pose depends on it
  MeshObjectSpec spec;
  spec.mesh = folder / ModelFileName(object_id);
  spec.unit = "mm";
  spec.mass_kg = kAnyMass_kg;
  spec.symmetries_O = info.symmetries_O;
  auto model = std::make_shared<ObjectModel>(*LoadMeshObject(name, spec));
  model->diameter_m = info.diameter_m;  // BOP's thresholds refer to the published diameter
  return model;
}

RgbdFrame ReadDepthFrame(const SceneTruth& scene, const ImageTruth& image) {
  const auto file = DepthFile(scene.folder, image.image_id, scene.sensor);
  const fs::path folder = scene.folder / OfSensor("depth", scene.sensor);
  CheckInput(file.has_value(),
             fmt::format("{}: is missing", (folder / ImageFileName(image.image_id)).string()));
  const Image<uint16_t> units = ReadPng16(*file);
  RgbdFrame frame;
  frame.intrinsics = image.projection.ForSize(units.width(), units.height());
  frame.depth_m = Image<float>(units.width(), units.height());
  const double unit_m = 1e-3 * image.depth_scale_mm;
  for (size_t i = 0; i < units.size(); ++i) {
    frame.depth_m.data()[i] = static_cast<float>(unit_m * units.data()[i]);
  }
  return frame;
}

std::vector<std::pair<int, int>> CameraSizes(const fs::path& root) {
  std::vector<std::pair<int, int>> sizes;
  for (const std::string& name : StemsIn(root, ".json")) {
    if (!name.starts_with("camera")) continue;
    const auto camera = ReadDatasetCamera(root / (name + ".json"), ThrowFault);
    if (camera) sizes.emplace_back(camera->intrinsics.width(), camera->intrinsics.height());
  }
  return sizes;
}

void CheckImageSize(const SceneTruth& scene, const ImageTruth& image, const RgbdFrame& frame,
                    const std::vector<std::pair<int, int>>& camera_sizes) {
  const std::pair size(frame.depth_m.width(), frame.depth_m.height());
  if (camera_sizes.empty() || std::ranges::count(camera_sizes, size) > 0) return;
  // Splits of some data sets have images of other sizes. Then both images have the same size.
  if (ColorFile(scene.folder, image.image_id, scene.sensor)) {
    ReadFrame(scene, image);
    return;
  }
  const auto file = DepthFile(scene.folder, image.image_id, scene.sensor);
  throw InputError(fmt::format("{}: is {} x {} pixels, but no camera*.json has this size",
                               file->string(), size.first, size.second));
}

RgbdFrame ReadFrame(const SceneTruth& scene, const ImageTruth& image) {
  RgbdFrame frame = ReadDepthFrame(scene, image);
  const auto file = ColorFile(scene.folder, image.image_id, scene.sensor);
  const fs::path folder = scene.folder / OfSensor("rgb", scene.sensor);
  CheckInput(file.has_value(),
             fmt::format("{}: is missing", (folder / ImageFileName(image.image_id)).string()));
  frame.color = ReadPng(*file);
  CheckInput(frame.color.width() == frame.depth_m.width() &&
                 frame.color.height() == frame.depth_m.height(),
             fmt::format("{}: is {} x {} pixels, its depth image {} x {}", file->string(),
                         frame.color.width(), frame.color.height(), frame.depth_m.width(),
                         frame.depth_m.height()));
  return frame;
}

}  // namespace pickbed::eval
