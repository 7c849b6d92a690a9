#include "scenes/base/settings_names.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <sstream>

#include "scenes/base/files.h"

namespace pickbed::scenes {
namespace {

// Replacement of one token of a text.
struct Edit {
  size_t at = 0;
  size_t length = 0;
  std::string token;
  ReplacedName name;
};

// Finds the place of a YAML node in its text.
class TextPlaces {
 public:
  explicit TextPlaces(const std::string& text) : text_(text) {
    starts_.push_back(text.starts_with(kByteOrderMark) ? std::strlen(kByteOrderMark) : 0);
    for (size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') starts_.push_back(i + 1);
    }
  }

  // Returns where the scalar `node` has its text `word`; nullopt if it is written in another way,
  // for example with escapes.
  std::optional<size_t> Find(const YAML::Node& node, const std::string& word) const {
    const YAML::Mark mark = node.Mark();
    if (mark.is_null() || mark.line >= static_cast<int>(starts_.size())) return std::nullopt;
    size_t at = starts_[mark.line] + mark.column;
    if (at < text_.size() && (text_[at] == '"' || text_[at] == '\'')) ++at;
    if (text_.compare(std::min(at, text_.size()), word.size(), word) != 0) return std::nullopt;
    return at;
  }

 private:
  const std::string& text_;
  std::vector<size_t> starts_;  // of the lines
};

// Walks a YAML node together with a Visit() and collects the edits.
class NameWalker : public SettingsVisitor {
 public:
  NameWalker(YAML::Node map, const TextPlaces& places, std::vector<Edit>& edits)
      : map_(std::move(map)), places_(places), edits_(edits) {}

  void RenamedKey(const char* was, const char* key) override {
    was_[key] = was;
    if (!map_.IsMap()) return;
    for (const auto& entry : map_) {
      if (entry.first.IsScalar() && entry.first.Scalar() == was) {
        Add(entry.first, was, key, {entry.first.Mark().line + 1, was, key});
      }
    }
  }

  void RenamedValue(const char* key, const char* was, const char* value) override {
    const auto node = Find(key);
    if (!node || !node->IsScalar() || node->Scalar() != was) return;
    Add(*node, was, value,
        {node->Mark().line + 1, fmt::format("{}: {}", key, was),
         fmt::format("{}: {}", key, value)});
  }

  void Group(const char* key, const VisitFunction& visit, const char*) override {
    if (const auto node = Find(key)) Walk(*node, visit);
  }

  void List(const char* key, size_t size, const std::function<void(size_t)>& resize,
            const std::function<void(size_t, SettingsVisitor&)>& visit, const char*) override {
    const auto node = Find(key);
    if (!node || !(node->IsSequence() || node->IsMap())) return;
    if (size == 0) resize(1);
    for (const auto& entry : *node) {  // of a map: items by index, from an assignment
      Walk(node->IsMap() ? entry.second : entry, [&](SettingsVisitor& item) { visit(0, item); });
    }
    if (size == 0) resize(0);
  }

  void Real(const char*, double&, Range, const char*) override {}
  void Integer(const char*, int&, Range, const char*) override {}
  void Seed(const char*, uint64_t&, const char*) override {}
  void Bool(const char*, bool&, const char*) override {}
  void Text(const char*, std::string&, const std::vector<std::string>&, const char*) override {}
  void Names(const char*, std::vector<std::string>&, const char*) override {}
  void Words(const char*, std::vector<std::string>&, const char*) override {}
  void Vector2(const char*, Eigen::Vector2d&, Range, const char*) override {}
  void Vector3(const char*, Eigen::Vector3d&, Range, const char*) override {}

 private:
  void Walk(const YAML::Node& node, const VisitFunction& visit) {
    if (!node.IsMap()) return;
    NameWalker child(node, places_, edits_);
    visit(child);
  }

  // Returns the node of a key by its name of now or its former name.
  std::optional<YAML::Node> Find(const char* key) const {
    if (!map_.IsMap()) return std::nullopt;
    const auto was = was_.find(key);
    for (const std::string& name : {std::string(key), was == was_.end() ? key : was->second}) {
      const YAML::Node node = map_[name];
      if (node.IsDefined()) return node;
    }
    return std::nullopt;
  }

  void Add(const YAML::Node& node, const std::string& word, const std::string& token,
           const ReplacedName& name) {
    if (const auto at = places_.Find(node, word)) edits_.push_back({*at, word.size(), token, name});
  }

  const YAML::Node map_;
  const TextPlaces& places_;
  std::vector<Edit>& edits_;
  std::map<std::string, std::string> was_;  // key -> former key
};

// Returns the edits ordered by position, each once: an anchor can be visited several times.
std::vector<Edit> EditsOf(const std::string& yaml, const VisitFunction& visit) {
  std::vector<Edit> edits;
  try {
    const TextPlaces places(yaml);
    NameWalker walker(YAML::Load(yaml), places, edits);
    visit(walker);
  } catch (const YAML::Exception&) {
    return {};
  }
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.at < b.at; });
  const auto same = [](const Edit& a, const Edit& b) { return a.at == b.at; };
  edits.erase(std::unique(edits.begin(), edits.end(), same), edits.end());
  return edits;
}

// Applies the edits in [begin, end) of the original text to that part.
std::string Edited(const std::string& text, const std::vector<Edit>& edits, size_t begin,
                   size_t end) {
  std::string result;
  size_t from = begin;
  for (const Edit& edit : edits) {
    if (edit.at < begin || edit.at >= end) continue;
    result += text.substr(from, edit.at - from) + edit.token;
    from = edit.at + edit.length;
  }
  return result + text.substr(from, end - from);
}

std::vector<ReplacedName> NamesOf(const std::vector<Edit>& edits) {
  std::vector<ReplacedName> names;
  for (const Edit& edit : edits) {
    const bool known = std::any_of(names.begin(), names.end(), [&](const ReplacedName& name) {
      return name.was == edit.name.was && name.is == edit.name.is;
    });
    if (!known) names.push_back(edit.name);
  }
  return names;
}

DeprecationListener& Listener() {
  static DeprecationListener listener;
  return listener;
}

}  // namespace

CurrentText WithCurrentNames(const std::string& yaml, const VisitFunction& visit) {
  const std::vector<Edit> edits = EditsOf(yaml, visit);
  return {Edited(yaml, edits, 0, yaml.size()), NamesOf(edits)};
}

CurrentText AssignmentWithCurrentNames(const std::string& assignment, const VisitFunction& visit) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos) return {assignment, {}};
  // "a.b=value" as "{a: {b: value}}"; the position of each key is kept.
  std::string text;
  std::vector<std::pair<size_t, size_t>> keys;  // begin, end
  std::stringstream path(assignment.substr(0, equals));
  for (std::string key; std::getline(path, key, '.');) {
    text += "{";
    keys.push_back({text.size(), text.size() + key.size()});
    text += key + ": ";
  }
  const size_t value = text.size();
  text += assignment.substr(equals + 1);
  const size_t end = text.size();
  text += std::string(keys.size(), '}');
  const std::vector<Edit> edits = EditsOf(text, visit);
  if (edits.empty()) return {assignment, {}};
  CurrentText current;
  for (const auto& [begin, key_end] : keys) {
    current.text += (current.text.empty() ? "" : ".") + Edited(text, edits, begin, key_end);
  }
  current.text += "=" + Edited(text, edits, value, end);
  current.replaced = NamesOf(edits);
  for (ReplacedName& name : current.replaced) name.line = 0;
  return current;
}

std::string DeprecationLine(const std::string& file, const std::vector<ReplacedName>& replaced) {
  std::string line;
  for (const ReplacedName& name : replaced) {
    const std::string place =
        line.empty() ? fmt::format("{}:{}", file, name.line) : fmt::format("; line {}", name.line);
    line += fmt::format("{}: '{}' is deprecated, write '{}'", place, name.was, name.is);
  }
  return line;
}

DeprecationListener SetDeprecationListener(DeprecationListener listener) {
  std::swap(listener, Listener());
  return listener;
}

void ReportDeprecation(const std::string& line) {
  if (Listener()) Listener()(line);
}

}  // namespace pickbed::scenes
