#pragma once

// The text form of a scenario that is stored in a results folder.

#include <filesystem>
#include <string>

#include "scenes/scenario/scenario_spec.h"

namespace pickbed::scenes {

// Returns every setting as YAML. Mesh paths are relative to `folder`, in which the text will be
// stored.
std::string ScenarioText(ScenarioSpec spec, const std::filesystem::path& folder);

// Reads the settings of such a text from `folder`. The bin's file and mesh are not loaded, and the
// settings are not validated. Errors use `name` as the file name. Throws InputError.
ScenarioSpec ScenarioOfText(const std::string& text, const std::filesystem::path& folder,
                            const std::string& name);

// Returns the dropped objects in words, such as "4 bracket, 2 rod". With a fill level, the counts
// are relative: "2 bracket : 1 rod, filled to 66 %".
std::string ObjectsInWords(const ScenarioSpec& spec);

}  // namespace pickbed::scenes
