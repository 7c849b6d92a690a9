#include "scenes/base/yaml.h"

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// Whether the text is valid UTF-8 (RFC 3629, section 4).
bool IsUtf8(std::string_view text) {
  for (size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at++]);
    if (first < 0x80) continue;
    const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
    if (first < 0xc2 || first > 0xf4) return false;
    uint32_t code = first & (0x3fu >> more);
    for (int i = 0; i < more; ++i) {
      if (at == text.size()) return false;
      const auto next = static_cast<unsigned char>(text[at++]);
      if ((next & 0xc0) != 0x80) return false;
      code = code << 6 | (next & 0x3fu);
    }
    constexpr uint32_t kFewest[] = {0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xd800 && code < 0xe000;
    if (code < kFewest[more] || code > 0x10ffff || is_surrogate) return false;
  }
  return true;
}

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
