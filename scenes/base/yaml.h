#pragma once

// Parsing of YAML texts of users.

#include <yaml-cpp/yaml.h>

#include <string>

namespace pickbed::scenes {

// Largest text and document that are read. Settings are far smaller. Larger ones are broken, or
// made to take all memory by aliases of aliases.
inline constexpr size_t kMaxYamlBytes = 4 << 20;  // an alias counts as the texts behind it
inline constexpr int kMaxYamlNodes = 200000;      // an alias counts as all nodes behind it
inline constexpr int kMaxYamlDepth = 64;

// Parses a YAML text. Throws InputError with `source` and the line if it is not valid, or larger
// than the limits; also for an alias that refers to a node around it.
YAML::Node ParseYaml(const std::string& text, const std::string& source);

// Throws InputError if the text of a file ends within a number, such as "0." without a line end.
void RequireWholeYaml(const std::string& text, const std::string& source);

}  // namespace pickbed::scenes
