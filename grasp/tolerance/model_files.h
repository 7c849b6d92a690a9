#pragma once

// Files of tolerance models, as written by `pickbed tolerance`, and their use for the objects of a
// scenario.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/tolerance/tolerance_model.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

inline constexpr char kToleranceModelFile[] = "model.yaml";  // in a folder of `pickbed tolerance`

// The model.yaml files of a place: the file itself, the file in the folder, or the files one folder
// deeper. Throws InputError if there are none.
std::vector<std::filesystem::path> ToleranceFiles(const std::filesystem::path& place);

// Throws InputError that names the file, unless the model was made from this mesh.
void RequireModelOf(const ToleranceModel& model, const ObjectModel& object,
                    const std::filesystem::path& file);

// Loads the models by object; nullopt for an object without a model. Each of `places` is a
// model.yaml, its folder, or a folder of such folders. From the last kind, only the models of an
// object in `objects` with this gripper are used. Throws InputError if a place has no usable model,
// or if two models are for the same object. Also throws it if a file or its own folder is for
// another object, gripper or mesh.
std::vector<std::optional<ToleranceModel>> LoadToleranceModels(
    const std::vector<std::string>& places, const ObjectSet& objects, const std::string& gripper);

// Uncertainty of an estimated pose: standard deviations of the position along each axis and of the
// rotation angle about a random axis through the center of mass.
struct PoseUncertainty {
  double position_m = 0;
  double rotation_rad = 0;
};

// Returns the probability that a pick with the grasp at X_OG succeeds at a pose with this
// uncertainty: mean of SuccessProbability() over `draws` errors, which are the same for all grasps
// of the object.
double ExpectedSuccess(const ToleranceModel& model, const ObjectModel& object, const Pose& X_OG,
                       const PoseUncertainty& uncertainty, int draws = 64);

}  // namespace pickbed::grasp
