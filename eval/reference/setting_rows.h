#pragma once

// Rows of the settings tables of the reference, from the Visit() of a settings struct.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::eval {

// Default value of an empty text or list.
inline constexpr char kEmptySetting[] = "empty";

// One key with its description. A group of keys has a row of its own before its keys.
struct SettingRow {
  std::string key;    // full path; the index of a list item is N: "objects.N.count"
  std::string value;  // type and range, or the choices, in words
  std::string default_value;
  std::string unit;
  std::string help;
};

// Returns the keys that `visit` names. Lists are resized to one default item.
std::vector<SettingRow> SettingRows(const VisitFunction& visit);

}  // namespace pickbed::eval
