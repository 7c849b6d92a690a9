#pragma once

// A scenario as the text that a results folder keeps of it.

#include <filesystem>
#include <string>

#include "scenes/scenario_spec.h"

namespace pickbed {

// Every setting, with the paths of meshes relative to `folder`, where the text is to lie.
std::string ScenarioText(ScenarioSpec spec, const std::filesystem::path& folder);

// The settings of such a text that lies in `folder`; what its bin's file says beyond it is left
// out. `name` is told in errors.
ScenarioSpec ScenarioOfText(const std::string& text, const std::filesystem::path& folder,
                            const std::string& name);

}  // namespace pickbed
