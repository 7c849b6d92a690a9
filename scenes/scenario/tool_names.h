#pragma once

// Names or files of the grippers among which a robot changes. One gripper is written as its name.

#include <string>
#include <utility>
#include <vector>

namespace pickbed::scenes {

struct ToolNames {
  std::vector<std::string> names;  // at least one; the first one stirs

  // Implicit, so that a setting with one gripper can be assigned and compared as a text.
  ToolNames(const char* name) : names{name} {}
  ToolNames(std::string name) : names{std::move(name)} {}
  ToolNames(std::vector<std::string> several) : names(std::move(several)) {}

  // Returns the names, separated by commas.
  std::string InWords() const {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  }
  friend bool operator==(const ToolNames&, const ToolNames&) = default;
};

}  // namespace pickbed::scenes
