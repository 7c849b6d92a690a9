#pragma once

// Finds scenarios by file or preset name and loads them with the objects that they need.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/load_objects.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::scenes {

// The scenario to load and its overrides.
struct ScenarioRequest {
  std::string scenario;               // a file, or the name of a preset
  std::vector<std::string> settings;  // "key=value" overrides, applied in order
  std::string catalog = "objects";    // folder of the user's own objects
  std::optional<int> trials;          // overrides the scenario's number of trials
};

// A scenario with its loaded objects.
struct LoadedScenario {
  std::string name;  // file name without folder and extension
  ScenarioSpec spec;
  ObjectSet objects;
};
// Loads the scenario file or preset, applies the settings, expands pools of objects
// (object_pool.h) and loads its objects. Sensor, gripper and model files are also searched in the
// scenario's folder. `on_object` is called after each loaded object. Throws InputError for an
// unknown name or a bad value.
LoadedScenario FindScenario(const ScenarioRequest& request, const ObjectProgress& on_object = {});

// Returns the catalog of the user's own folder and, with lower priority, the shipped one.
ObjectCatalog OpenCatalog(const std::string& own_folder);

// Returns the folder of the shipped scenarios.
std::filesystem::path PresetsDir();
// Returns the sorted names of the shipped scenarios.
std::vector<std::string> PresetNames();

}  // namespace pickbed::scenes
