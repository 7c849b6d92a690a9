#pragma once

// The tolerance models (grasp/tolerance.h) of a scenario's parts with its gripper, which turn the
// pose error of any hypothesis into a chance that a pick on it succeeds.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/trial.h"
#include "grasp/tolerance.h"
#include "scenes/object_model.h"

namespace pickbed {

class ToleranceMaps {
 public:
  ToleranceMaps() = default;  // no part has one
  // Each of `places` is a model.yaml of `pickbed tolerance`, its folder, or a folder of such
  // folders, of which those are taken that are of a part in `objects` with the gripper of this
  // name. Throws InputError when a place holds none, when a file or its own folder is of another
  // part, gripper or mesh, and when two are of one part.
  ToleranceMaps(const std::vector<std::string>& places, const ObjectSet& objects,
                const std::string& gripper);

  bool empty() const { return by_object_.empty(); }
  // Null where the part has none.
  const ToleranceModel* Of(int object) const;
  // Nothing where the part has no model; 0 for a pose that stands on no part of its kind, which the
  // model knows nothing of.
  std::optional<double> PickChance(const HypothesisScore& hypothesis) const;
  // The same for one grasp of it, instead of the mean over the model's grasps.
  std::optional<double> PickChance(const HypothesisScore& hypothesis, const Grasp& grasp) const;

 private:
  std::vector<std::optional<ToleranceModel>> by_object_;
};

// Of a scenario's own gripper; none for no places.
ToleranceMaps MapsFor(const ScenarioSpec& spec, const ObjectSet& objects,
                      const std::vector<std::string>& places);

// The model.yaml files of a place: itself, the one in it, or those one folder deeper. Throws
// InputError when there are none.
std::vector<std::filesystem::path> ToleranceFiles(const std::filesystem::path& place);

// Throws InputError naming the file unless the model was made of this mesh.
void RequireModelOf(const ToleranceModel& model, const ObjectModel& part,
                    const std::filesystem::path& file);

}  // namespace pickbed
