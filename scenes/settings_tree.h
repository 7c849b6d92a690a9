#pragma once

// A YAML file whose keys are settings themselves, such as the grid of a sweep: read as it stands,
// with the place of each entry, and applied to settings structs later.

#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/settings.h"

namespace pickbed {

struct SettingsTree {
  enum class Kind { kValue, kList, kMap };
  Kind kind = Kind::kValue;
  std::string key;    // in its map, empty in a list
  std::string text;   // the value as YAML in one line
  std::string place;  // "sweep.yaml:7"
  std::vector<SettingsTree> items;

  const SettingsTree* Find(const std::string& name) const;  // null: the map has no such key
};

// Throws InputError for a file that cannot be read, is no map, or gives a key twice.
SettingsTree ReadSettingsTree(const std::filesystem::path& file);
SettingsTree ReadSettingsTreeText(const std::string& yaml, const std::string& name_for_errors);

// A setting of a tree: "estimator.name=ppf", and where it was given.
struct PlacedSetting {
  std::string assignment;
  std::string place;
};

// The entries of a map as settings. Throws InputError when it is none.
std::vector<PlacedSetting> SettingsIn(const SettingsTree& map);

// `error` anew, with the place of the setting that it blames as a --set.
[[noreturn]] void ThrowPlaced(const std::vector<PlacedSetting>& settings,
                              const std::exception& error);

// What `apply` returns when it is given the assignments; an InputError that blames one of them as a
// --set is thrown anew with the place where it was given.
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
// A map read into what `visit` names, as ReadSettingsFile does.
void ReadSettingsBlock(const SettingsTree& map, const VisitFunction& visit);

}  // namespace pickbed
