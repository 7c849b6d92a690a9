#pragma once

// Executed picks of a results folder with the errors of their poses.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/tolerance/statistics.h"

namespace pickbed::eval {

// Returns the picks of the object named `object` whose estimated poses match a true instance;
// clusters are the bins. Throws InputError if the folder holds no results or no such pick. Also
// throws it if the run used another gripper, or if the model, sensor or object has changed since
// the run, or if a trial is damaged.
std::vector<JudgedPick> PicksOfRun(const std::filesystem::path& folder, const std::string& catalog,
                                   const std::string& object, const std::string& gripper);

}  // namespace pickbed::eval
