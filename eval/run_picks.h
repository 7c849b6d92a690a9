#pragma once

// The executed picks of a run's results folder, with how wrong their poses were.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/tolerance_figures.h"

namespace pickbed {

// Picks of the part `object`, whose believed poses stood on a true part; clusters are the bins.
// Throws InputError when the folder holds no results, the run was made with another gripper, or
// nothing of it was picked.
std::vector<JudgedPick> PicksOfRun(const std::filesystem::path& folder, const std::string& catalog,
                                   const std::string& object, const std::string& gripper);

}  // namespace pickbed
