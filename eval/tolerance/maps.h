#pragma once

// Tolerance models (grasp/tolerance/tolerance_model.h) of the objects of a scenario with its
// gripper. They convert the pose error of a hypothesis into the success probability of a pick.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/trial/trial.h"
#include "grasp/tolerance/tolerance_model.h"
#include "scenes/base/ids.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

inline constexpr char kToleranceModelFile[] = "model.yaml";  // in a folder of `pickbed tolerance`

// Tolerance models by object.
class ToleranceMaps {
 public:
  ToleranceMaps() = default;  // no object has a model
  // Loads the models. Each of `places` is a model.yaml of `pickbed tolerance`, its folder, or a
  // folder of such folders. From the last kind, only the models of an object in `objects` with this
  // gripper are used. Throws InputError if a place has no usable model, or if two models are for
  // the same object. Also throws it if a file or its own folder is for another object, gripper or
  // mesh.
  ToleranceMaps(const std::vector<std::string>& places, const ObjectSet& objects,
                const std::string& gripper);

  bool empty() const { return by_object_.empty(); }
  // Model of an object; null if it has none.
  const ToleranceModel* Of(ObjectId object) const;
  // Success probability of a pick on the hypothesis. nullopt if the object has no model. 0 if the
  // pose matches no instance of its object, because the model does not cover that case.
  std::optional<double> PickChance(const HypothesisRecord& hypothesis) const;
  // Like above, for the given grasp instead of the mean over the grasps of the model.
  std::optional<double> PickChance(const HypothesisRecord& hypothesis, const Grasp& grasp) const;

 private:
  std::vector<std::optional<ToleranceModel>> by_object_;
};

// Models for the gripper of a scenario; none if `places` is empty.
ToleranceMaps MapsFor(const ScenarioSpec& spec, const ObjectSet& objects,
                      const std::vector<std::string>& places);

// The model.yaml files of a place: the file itself, the file in the folder, or the files one folder
// deeper. Throws InputError if there are none.
std::vector<std::filesystem::path> ToleranceFiles(const std::filesystem::path& place);

// Throws InputError that names the file, unless the model was made from this mesh.
void RequireModelOf(const ToleranceModel& model, const ObjectModel& object,
                    const std::filesystem::path& file);

}  // namespace pickbed::eval
