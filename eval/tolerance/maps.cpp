#include "eval/tolerance/maps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "eval/trial/pose_matching.h"
#include "grasp/grippers/table.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
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

// True if the place is a single model, not a folder with several.
bool IsOne(const fs::path& place) {
  return !fs::is_directory(place) || fs::is_regular_file(place / kToleranceModelFile);
}

bool MatchesAnInstance(const HypothesisRecord& hypothesis) {
  return hypothesis.instance >= 0 && hypothesis.mssd_diameters() < kMatchDiameters;
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

ToleranceMaps::ToleranceMaps(const std::vector<std::string>& places, const ObjectSet& objects,
                             const std::string& gripper) {
  if (places.empty()) return;
  by_object_.resize(objects.size());
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
      by_object_[object] = std::move(model);
      any = true;
    }
    CheckInput(any, fmt::format("tolerance map {}: there is no map of {} with {}; make one with "
                                "pickbed tolerance OBJECT GRIPPER",
                                place, NamesOf(objects), gripper));
  }
}

const ToleranceModel* ToleranceMaps::Of(ObjectId object) const {
  if (empty()) return nullptr;
  const auto& model = by_object_.at(object);
  return model ? &*model : nullptr;
}

std::optional<double> ToleranceMaps::PickChance(const HypothesisRecord& hypothesis) const {
  const ToleranceModel* model = Of(hypothesis.object);
  if (model == nullptr) return std::nullopt;
  if (!MatchesAnInstance(hypothesis)) return 0;
  return SuccessProbability(*model, hypothesis.X_OE);
}

std::optional<double> ToleranceMaps::PickChance(const HypothesisRecord& hypothesis,
                                                const Grasp& grasp) const {
  const ToleranceModel* model = Of(hypothesis.object);
  if (model == nullptr) return std::nullopt;
  if (!MatchesAnInstance(hypothesis)) return 0;
  return SuccessProbability(*model, hypothesis.X_OE, hypothesis.X_WO.inverse() * grasp.X_WG);
}

ToleranceMaps MapsFor(const ScenarioSpec& spec, const ObjectSet& objects,
                      const std::vector<std::string>& places) {
  if (places.empty()) return {};
  const auto gripper = WithSettingsKey(spec, "gripper", [&] {
    CheckInput(
        spec.gripper.names.size() == 1,
        fmt::format("= {}: a tolerance map is for one gripper; name one, or leave out the maps",
                    spec.gripper.InWords()));
    return LoadGripper(spec.gripper.names[0]);
  });
  return ToleranceMaps(places, objects, gripper->name);
}

}  // namespace pickbed::eval
