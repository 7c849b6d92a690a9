#include "scenes/base/yaml.h"

#include <fmt/format.h>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// Counts nodes as a reader visits them, which follows aliases.
void Count(const YAML::Node& node, const std::string& source, int depth, int& nodes) {
  const auto place = [&] { return fmt::format("{}:{}", source, node.Mark().line + 1); };
  if (depth > kMaxYamlDepth) {
    throw InputError(fmt::format("{}: is nested more than {} levels deep, or refers to itself",
                                 place(), kMaxYamlDepth));
  }
  if (++nodes > kMaxYamlNodes) {
    throw InputError(fmt::format("{}: has more than {} values", place(), kMaxYamlNodes));
  }
  if (node.IsScalar()) {
    CheckInput(IsUtf8(node.Scalar()), fmt::format("{}: '{}' is not UTF-8; save the file as UTF-8",
                                                  place(), OneLine(node.Scalar())));
  } else if (node.IsSequence()) {
    for (const YAML::Node& item : node) Count(item, source, depth + 1, nodes);
  } else if (node.IsMap()) {
    for (const auto& entry : node) {
      Count(entry.first, source, depth + 1, nodes);
      Count(entry.second, source, depth + 1, nodes);
    }
  }
}

}  // namespace

YAML::Node ParseYaml(const std::string& text, const std::string& source) {
  CheckInput(text.size() <= kMaxYamlBytes, fmt::format("{}: has {} bytes; a YAML file may have {}",
                                                       source, text.size(), kMaxYamlBytes));
  try {
    YAML::Node node = YAML::Load(text);
    int nodes = 0;
    Count(node, source, 0, nodes);
    return node;
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: not valid YAML: {}", source, error.mark.line + 1, OneLine(error.msg)));
  }
}

}  // namespace pickbed::scenes
