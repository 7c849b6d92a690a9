#include "grasp/tolerance/model_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/base/random.h"

namespace pickbed::grasp {
namespace {

namespace fs = std::filesystem;

ObjectId IndexOf(const std::string& name, const ObjectSet& objects) {
  for (size_t i = 0; i < objects.size(); ++i) {
    if (objects[i]->name == name) return ObjectId(i);
  }
  return kAnyObject;
}

std::string NamesOf(const ObjectSet& objects) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  return fmt::format("{}", fmt::join(names, ", "));
}

// Returns true if the path is a single model, not a folder with several.
bool IsOne(const fs::path& place) {
  return !fs::is_directory(place) || fs::is_regular_file(place / kToleranceModelFile);
}

}  // namespace

std::vector<fs::path> ToleranceFiles(const fs::path& place) {
  CheckInput(fs::exists(place),
             fmt::format("tolerance map {}: there is no such file or folder", place.string()));
  if (!fs::is_directory(place)) return {place};
  if (fs::is_regular_file(place / kToleranceModelFile)) return {place / kToleranceModelFile};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(place)) {
    if (fs::is_regular_file(entry.path() / kToleranceModelFile))
      files.push_back(entry.path() / kToleranceModelFile);
  }
  std::sort(files.begin(), files.end());
  CheckInput(!files.empty(),
             fmt::format("tolerance map {}: neither this folder nor its sub-folders have a {}; "
                         "make one with pickbed tolerance OBJECT GRIPPER",
                         place.string(), kToleranceModelFile));
  return files;
}

void RequireModelOf(const ToleranceModel& model, const ObjectModel& object, const fs::path& file) {
  constexpr double kSame = 1e-3;  // of the extent of the surface
  const ToleranceModel wanted = EmptyToleranceModel(object, model.gripper, {Pose::Identity()});
  const double extent_m2 = wanted.surface_covariance_O.trace();
  const bool same =
      (model.surface_mean_O - wanted.surface_mean_O).squaredNorm() < kSame * extent_m2 &&
      (model.surface_covariance_O - wanted.surface_covariance_O).norm() < kSame * extent_m2;
  CheckInput(
      same,
      fmt::format(
          "{}: was made with another mesh of '{}'; make it again with pickbed tolerance {} {}",
          file.string(), object.name, object.name, model.gripper));
}

std::vector<std::optional<ToleranceModel>> LoadToleranceModels(
    const std::vector<std::string>& places, const ObjectSet& objects, const std::string& gripper) {
  std::vector<std::optional<ToleranceModel>> models(objects.size());
  std::vector<std::string> files_of(objects.size());
  for (const std::string& place : places) {
    bool any = false;
    for (const fs::path& file : ToleranceFiles(place)) {
      ToleranceModel model = ReadToleranceModel(file);
      const ObjectId object = IndexOf(model.object, objects);
      const bool fits = object >= 0 && model.gripper == gripper;
      CheckInput(
          fits || !IsOne(place),
          fmt::format("{}: is a map of {} with {}; the objects are {}, the gripper is {}",
                      file.string(), model.object, model.gripper, NamesOf(objects), gripper));
      if (!fits) continue;
      RequireModelOf(model, *objects[object], file);
      CheckInput(files_of[object].empty(),
                 fmt::format("{} and {} are both maps of {} with {}; name one of them",
                             files_of[object], file.string(), model.object, gripper));
      files_of[object] = file.string();
      models[object] = std::move(model);
      any = true;
    }
    CheckInput(any, fmt::format("tolerance map {}: there is no map of {} with {}; make one with "
                                "pickbed tolerance OBJECT GRIPPER",
                                place, NamesOf(objects), gripper));
  }
  return models;
}

double ExpectedSuccess(const ToleranceModel& model, const ObjectModel& object, const Pose& X_OG,
                       const PoseUncertainty& uncertainty, int draws) {
  Rng rng(object.mesh_hash);
  double sum = 0;
  for (int i = 0; i < draws; ++i) {
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) shift_m[axis] = uncertainty.position_m * rng.Normal();
    const double angle_rad = uncertainty.rotation_rad * rng.Normal();
    const Eigen::AngleAxisd rotation(angle_rad, rng.UnitVector());
    const Eigen::Vector3d& com_O = object.mass.com_O;
    const Pose X_OE = Translation(com_O + shift_m) * rotation * Translation(-com_O);
    sum += SuccessProbability(model, X_OE, X_OG);
  }
  return sum / draws;
}

}  // namespace pickbed::grasp
