#pragma once

// Notes on a scenario for the console: what a user may not expect of its settings.

#include <string>

#include "eval/layer.h"
#include "scenes/objects/object_model.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Returns whether the planner of this scenario works with poses. Throws InputError with the place
// of planner.name if it is unknown.
bool NeedsPoses(const ScenarioSpec& spec);

// Returns one line for each setting from the command line that this scenario does not use, such as
// a mode of the oracle estimator. Empty if there is none.
std::string UnusedSettings(const ScenarioSpec& spec);

// Returns whether a run of this scenario loads an estimator, which refuses objects that are too
// small in the image.
bool LoadsEstimator(const ScenarioSpec& spec);

// Returns a line if an object is too small in the image for every estimator. Empty otherwise.
std::string SmallObjectNote(const ScenarioSpec& spec, const ObjectSet& objects);

}  // namespace pickbed::eval
