#pragma once

// A YAML file whose keys are themselves settings, such as the grid of a sweep. It is read without
// interpretation, with the place of each entry, and applied to settings structs later.

#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// One node of such a file.
struct SettingsTree {
  enum class Kind { kValue, kList, kMap };
  Kind kind = Kind::kValue;
  std::string key;    // key in the parent map; empty in a list
  std::string text;   // the value as YAML in one line
  std::string place;  // file and line, such as "sweep.yaml:7"
  std::vector<SettingsTree> items;

  const SettingsTree* Find(const std::string& name) const;  // null if the map has no such key
};

// Reads a YAML file. Throws InputError if the file cannot be read, is not a map or repeats a key.
SettingsTree ReadSettingsTree(const std::filesystem::path& file);
// Same for a YAML text; errors use `name_for_errors` as the file name.
SettingsTree ReadSettingsTreeText(const std::string& yaml, const std::string& name_for_errors);

// A setting of a tree, such as "estimator.name=ppf", and the file and line where it was given.
struct PlacedSetting {
  std::string assignment;
  std::string place;
};

// Returns the entries of a map as settings. Throws InputError if the node is not a map.
std::vector<PlacedSetting> SettingsIn(const SettingsTree& map);

// Rethrows `error`. In the message of an InputError, each "setting <assignment>" from `settings` is
// replaced by the place where that setting was given. Call it only inside a catch block.
[[noreturn]] void ThrowPlaced(const std::vector<PlacedSetting>& settings,
                              const std::exception& error);

// Calls `apply` with the assignments of `settings` and returns its result. An InputError that names
// one of them is rethrown with the place where the setting was given.
template <typename Apply>
auto ApplyPlaced(const std::vector<PlacedSetting>& settings, const Apply& apply) {
  std::vector<std::string> assignments;
  for (const PlacedSetting& setting : settings) assignments.push_back(setting.assignment);
  try {
    return apply(assignments);
  } catch (const std::exception& error) {
    ThrowPlaced(settings, error);
  }
}
// Applies the entries of a map to the fields that `visit` names. Throws the same as
// ReadSettingsFile().
void ReadSettingsBlock(const SettingsTree& map, const VisitFunction& visit);

// Returns whether a key is a damaged or misspelled form of a known one: they have the same length
// and differ in one letter. For files of other programs, which may have any other keys.
bool IsDamagedKey(std::string_view key, std::string_view known);

}  // namespace pickbed::scenes
