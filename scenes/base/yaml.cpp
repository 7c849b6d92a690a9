#include "scenes/base/yaml.h"

#include <fmt/format.h>

#include <sstream>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// Nodes and bytes of text as a reader visits them, which follows aliases.
struct Extent {
  int nodes = 0;
  size_t bytes = 0;
};

void Measure(const YAML::Node& node, const std::string& source, int depth, Extent& extent) {
  const auto place = [&] { return fmt::format("{}:{}", source, node.Mark().line + 1); };
  if (depth > kMaxYamlDepth) {
    throw InputError(fmt::format("{}: is nested more than {} levels deep, or refers to itself",
                                 place(), kMaxYamlDepth));
  }
  if (++extent.nodes > kMaxYamlNodes) {
    throw InputError(fmt::format("{}: has more than {} values", place(), kMaxYamlNodes));
  }
  if (node.IsScalar()) {
    extent.bytes += node.Scalar().size();
    if (extent.bytes > kMaxYamlBytes) {
      throw InputError(fmt::format("{}: has more than {} bytes with the texts behind its aliases",
                                   place(), kMaxYamlBytes));
    }
    CheckInput(IsUtf8(node.Scalar()), fmt::format("{}: '{}' is not UTF-8; save the file as UTF-8",
                                                  place(), OneLine(node.Scalar())));
  } else if (node.IsSequence()) {
    for (const YAML::Node& item : node) Measure(item, source, depth + 1, extent);
  } else if (node.IsMap()) {
    for (const auto& entry : node) {
      Measure(entry.first, source, depth + 1, extent);
      Measure(entry.second, source, depth + 1, extent);
    }
  }
}

// YAML permits no control characters but tabs and line ends.
void RequirePrintable(const std::string& text, const std::string& source) {
  int line = 1;
  for (const char c : text) {
    line += c == '\n';
    const bool is_control =
        (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) && c != '\t' && c != '\n' && c != '\r';
    CheckInput(!is_control, fmt::format("{}:{}: has the control character {:#04x}; remove it",
                                        source, line, static_cast<unsigned char>(c)));
  }
}

// Returns whether a line has a tab before its first word.
bool IsIndentedByTab(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const size_t word = line.find_first_not_of(" \t");
    const size_t tab = line.find('\t');
    if (word != std::string::npos && tab < word) return true;
  }
  return false;
}

}  // namespace

YAML::Node ParseYaml(const std::string& text, const std::string& source) {
  CheckInput(text.size() <= kMaxYamlBytes, fmt::format("{}: has {} bytes; a YAML file may have {}",
                                                       source, text.size(), kMaxYamlBytes));
  RequirePrintable(text, source);
  try {
    YAML::Node node = YAML::Load(text);
    Extent extent;
    Measure(node, source, 0, extent);
    return node;
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: not valid YAML: {}{}", source, error.mark.line + 1, OneLine(error.msg),
                    IsIndentedByTab(text) ? " (tabs are not allowed; use spaces)" : ""));
  }
}

void RequireWholeYaml(const std::string& text, const std::string& source) {
  const size_t at = text.find_last_of(" \t\n\r[]{},:#");
  const std::string word = at == std::string::npos ? text : text.substr(at + 1);
  const bool is_cut = word.size() > 1 && word.back() == '.' &&
                      word.find_first_not_of("0123456789+-.") == std::string::npos;
  const size_t line = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
  CheckInput(
      !is_cut || text.find('#', line) != std::string::npos,
      fmt::format("{}: ends with '{}', so it may be cut short; get it again, or end its last "
                  "line",
                  source, word));
}

}  // namespace pickbed::scenes
