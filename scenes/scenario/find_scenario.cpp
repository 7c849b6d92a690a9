#include "scenes/scenario/find_scenario.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/scenario/object_pool.h"

namespace pickbed::scenes {
namespace {

// Returns the file if it exists, else the preset of that name.
std::filesystem::path ScenarioFile(const std::string& scenario) {
  const std::filesystem::path file(scenario);
  if (Exists(file)) {
    CheckInput(!std::filesystem::is_directory(file),
               fmt::format("{} is a folder; name the scenario file in it", scenario));
    return file;
  }
  const std::filesystem::path preset = PresetsDir() / (scenario + ".yaml");
  if (!file.has_parent_path() && Exists(preset)) return preset;
  const std::string message = UnknownNameMessage("scenario", scenario, PresetNames());
  throw InputError(message + " (or the path of a scenario file; no file has this name)");
}

// Replaces a file name that is not found from the current folder but exists in the scenario's
// folder.
void FindBeside(const std::filesystem::path& folder, std::string& name_or_path) {
  const std::filesystem::path path(name_or_path);
  if (path.empty() || Exists(path)) return;
  if (IsRegularFile(folder / path)) name_or_path = (folder / path).string();
}

}  // namespace

LoadedScenario FindScenario(const ScenarioRequest& request, const ObjectProgress& on_object) {
  const std::filesystem::path file = ScenarioFile(request.scenario);
  std::vector<std::string> settings = request.settings;
  if (request.trials) settings.push_back(fmt::format("trials={}", *request.trials));
  LoadedScenario loaded;
  loaded.name = file.stem().string();
  loaded.spec = LoadScenario(file, settings);
  ExpandObjects(loaded.spec);
  for (std::string* named : {&loaded.spec.sensor, &loaded.spec.estimator.model,
                             &loaded.spec.estimator.calibration, &loaded.spec.roi.mask}) {
    FindBeside(loaded.spec.folder, *named);
  }
  for (std::string& word : loaded.spec.estimator.command) FindBeside(loaded.spec.folder, word);
  for (std::string& word : loaded.spec.planner.command) FindBeside(loaded.spec.folder, word);
  for (std::string& tool : loaded.spec.gripper.names) FindBeside(loaded.spec.folder, tool);
  loaded.objects = LoadObjects(loaded.spec, OpenCatalog(request.catalog), on_object);
  return loaded;
}

ObjectCatalog OpenCatalog(const std::string& own_folder) {
  return ObjectCatalog({own_folder, AssetsDir() / "objects"});
}

std::filesystem::path PresetsDir() {
  const std::filesystem::path installed = AssetsDir().parent_path() / "presets";
  if (Exists(installed)) return installed;
  return AssetsDir().parent_path() / "scenes" / "presets";
}

std::vector<std::string> PresetNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(PresetsDir(), error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace pickbed::scenes
