#pragma once

// Tolerance models (grasp/tolerance/tolerance_model.h) of the objects of a scenario with its
// gripper. They convert the pose error of a hypothesis into the success probability of a pick.

#include <optional>
#include <string>
#include <vector>

#include "eval/trial/trial.h"
#include "grasp/tolerance/model_files.h"
#include "grasp/tolerance/tolerance_model.h"
#include "scenes/base/ids.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Tolerance models by object.
class ToleranceMaps {
 public:
  ToleranceMaps() = default;  // no object has a model
  // Loads the models; none if `places` is empty. Throws as LoadToleranceModels().
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

}  // namespace pickbed::eval
