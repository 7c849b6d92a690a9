#include "scenes/base/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <sstream>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/base/setting_rules.h"
#include "scenes/base/settings_names.h"
#include "scenes/base/yaml.h"

namespace pickbed::scenes {
namespace {

// The items of a list of texts; nullopt for another node.
std::optional<std::vector<std::string>> Texts(const YAML::Node& node) {
  if (!node.IsSequence()) return std::nullopt;
  std::vector<std::string> texts;
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) return std::nullopt;
    texts.push_back(item.Scalar());
  }
  return texts;
}

std::vector<std::string> WordsOf(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// Reads one YAML map into the visited fields, then rejects keys that no field has.
class Reader : public SettingsVisitor {
 public:
  // `has_lines`: the source is a file, so errors give the line number.
  Reader(YAML::Node map, std::string source, bool has_lines)
      : map_(std::move(map)), source_(std::move(source)), has_lines_(has_lines) {}

  const KeyPlaces& places() const { return places_; }

  void Real(const char* key, double& value, Range range, const char* help) override {
    if (auto node = Find(key)) value = Number(*node, Path(key), range, help);
  }

  void Integer(const char* key, int& value, Range range, const char* help) override {
    auto node = Find(key);
    if (!node) return;
    const double number = Number(*node, Path(key), range, help);
    if (number != std::floor(number)) {
      Fail(*node, Path(key), fmt::format("must be a whole number ({})", help));
    }
    value = static_cast<int>(number);
  }

  void Seed(const char* key, uint64_t& value, const char* help) override {
    auto node = Find(key);
    if (!node) return;
    // as<uint64_t> would read "-1" as a large number.
    const std::string text = node->IsScalar() ? node->Scalar() : "";
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    try {
      if (!digits) throw std::out_of_range("seed");
      value = std::stoull(text);
    } catch (const std::out_of_range&) {
      Fail(*node, Path(key),
           fmt::format("must be a whole number from 0 to 18446744073709551615 ({})", help));
    }
  }

  void Bool(const char* key, bool& value, const char* help) override {
    auto node = Find(key);
    if (node && !(node->IsScalar() && YAML::convert<bool>::decode(*node, value))) {
      Fail(*node, Path(key), fmt::format("must be true or false ({})", help));
    }
  }

  void Text(const char* key, std::string& value, const std::vector<std::string>& choices,
            const char* help) override {
    auto node = Find(key);
    if (!node) return;
    if (!node->IsScalar()) Fail(*node, Path(key), fmt::format("must be one text ({})", help));
    value = node->Scalar();
    if (IsChoice(value, choices)) return;
    throw InputError(
        fmt::format("{}: {}", Where(*node), UnknownNameMessage(Path(key), value, choices)));
  }

  void Names(const char* key, std::vector<std::string>& value, const char* help) override {
    auto node = Find(key);
    if (!node) return;
    const auto names = node->IsScalar() ? std::optional(std::vector{node->Scalar()}) : Texts(*node);
    if (!names || names->empty()) {
      Fail(*node, Path(key), fmt::format("must be a name or a list of names ({})", help));
    }
    value = *names;
  }

  void Words(const char* key, std::vector<std::string>& value, const char* help) override {
    auto node = Find(key);
    if (!node) return;
    const auto words = node->IsScalar() ? std::optional(WordsOf(node->Scalar())) : Texts(*node);
    if (!words) Fail(*node, Path(key), fmt::format("must be a list of words ({})", help));
    value = *words;
  }

  void Vector2(const char* key, Eigen::Vector2d& value, Range range, const char* help) override {
    if (auto node = Find(key)) ReadVector(*node, Path(key), value, range, help);
  }

  void Vector3(const char* key, Eigen::Vector3d& value, Range range, const char* help) override {
    if (auto node = Find(key)) ReadVector(*node, Path(key), value, range, help);
  }

  void Group(const char* key, const VisitFunction& visit, const char*) override {
    const auto node = Find(key);
    if (!node) return;
    ReadChild(*node, Path(key), visit);
  }

  void List(const char* key, size_t size, const std::function<void(size_t)>& resize,
            const std::function<void(size_t, SettingsVisitor&)>& visit, const char* help) override {
    const auto node = Find(key);
    if (!node) return;
    if (node->IsMap()) return ReadListItems(*node, Path(key), size, visit);
    if (!node->IsSequence()) Fail(*node, Path(key), fmt::format("must be a list ({})", help));
    resize(node->size());
    for (size_t i = 0; i < node->size(); ++i) {
      ReadChild((*node)[i], fmt::format("{}.{}", Path(key), i),
                [&](SettingsVisitor& item) { visit(i, item); });
    }
  }

  // Throws for repeated keys and for keys that were not visited. Call it after the visit.
  void RejectUnknownKeys() const {
    if (!map_.IsDefined() || map_.IsNull()) return;
    if (!map_.IsMap()) {
      Fail(map_, prefix_,
           fmt::format("expected 'key: value' lines, with keys {}", fmt::join(known_, ", ")));
    }
    std::map<std::string, YAML::Node> seen;
    for (const auto& entry : map_) {
      const std::string key = entry.first.as<std::string>("?");
      const auto [first, is_new] = seen.try_emplace(key, entry.second);
      if (!is_new) {
        throw InputError(fmt::format("{}: {} = {}: is given twice, before as {} at {}; remove one",
                                     Where(entry.first), Path(key), Flat(entry.second),
                                     Flat(first->second), Where(first->second)));
      }
      bool known = false;
      for (const std::string& name : known_) known |= name == key;
      if (known) continue;
      const std::string kind = prefix_.empty() ? "key" : fmt::format("key in {}", prefix_);
      throw InputError(fmt::format("{}: {} (value: {})", Where(entry.first),
                                   UnknownNameMessage(kind, key, known_), Flat(entry.second)));
    }
  }

 private:
  std::optional<YAML::Node> Find(const char* key) {
    known_.push_back(key);
    if (!map_.IsDefined() || !map_.IsMap()) return std::nullopt;
    const YAML::Node node = static_cast<const YAML::Node&>(map_)[key];
    if (!node.IsDefined()) return std::nullopt;
    places_[Path(key)] = Where(node);
    return node;
  }

  void ReadChild(const YAML::Node& node, const std::string& path, const VisitFunction& visit) {
    Reader child(node, source_, has_lines_);
    child.prefix_ = path;
    visit(child);
    child.RejectUnknownKeys();
    places_.merge(child.places_);
  }

  std::string Path(const std::string& key) const {
    return prefix_.empty() ? key : prefix_ + "." + key;
  }

  std::string Where(const YAML::Node& node) const {
    const YAML::Mark mark = node.Mark();
    if (mark.is_null() || !has_lines_) return source_;
    return fmt::format("{}:{}", source_, mark.line + 1);
  }

  static std::string Flat(const YAML::Node& node) {
    YAML::Emitter out;
    out << YAML::Flow << node;
    return OneLine(out.c_str());
  }

  [[noreturn]] void Fail(const YAML::Node& node, const std::string& key,
                         const std::string& allowed) const {
    const std::string what = key.empty() ? Flat(node) : fmt::format("{} = {}", key, Flat(node));
    throw InputError(fmt::format("{}: {}: {}", Where(node), what, allowed));
  }

  double Number(const YAML::Node& node, const std::string& key, Range range,
                const char* help) const {
    double number = 0;
    const bool ok = node.IsScalar() && YAML::convert<double>::decode(node, number);
    if (!ok || !IsIn(range, number)) Fail(node, key, NumberRule(range, help));
    return number;
  }

  template <typename Vector>
  void ReadVector(const YAML::Node& node, const std::string& key, Vector& value, Range range,
                  const char* help) const {
    if (!node.IsSequence() || node.size() != static_cast<size_t>(value.size())) {
      Fail(node, key, fmt::format("must be a list of {} numbers ({})", value.size(), help));
    }
    for (int i = 0; i < value.size(); ++i) value[i] = Number(node[i], key, range, help);
  }

  // "objects.0.count=3" as an assignment arrives as a map from index to fields.
  void ReadListItems(const YAML::Node& node, const std::string& key, size_t size,
                     const std::function<void(size_t, SettingsVisitor&)>& visit) {
    for (const auto& entry : node) {
      size_t index = size;
      try {
        index = entry.first.as<size_t>();
      } catch (const YAML::Exception&) {
      }
      if (index >= size) {
        Fail(entry.first, key,
             fmt::format("must be the index of an item, 0 to {}", static_cast<long>(size) - 1));
      }
      ReadChild(entry.second, fmt::format("{}.{}", key, index),
                [&](SettingsVisitor& item) { visit(index, item); });
    }
  }

  YAML::Node map_;
  std::string source_;
  bool has_lines_;
  std::string prefix_;  // path of this map, such as "objects.0"; empty for the outermost map
  KeyPlaces places_;
  std::vector<std::string> known_;
};

// Writes every visited field. Reading the text gives the same values again.
class Writer : public SettingsVisitor {
 public:
  enum class Names { kCurrent, kFormer };
  explicit Writer(bool with_help, Names names = Names::kCurrent)
      : with_help_(with_help), former_(names == Names::kFormer) {}

  void RenamedKey(const char* was, const char* key) override {
    if (former_) former_keys_.back().emplace(key, was);
  }
  void RenamedValue(const char* key, const char* was, const char* value) override {
    if (former_) former_values_.back().emplace(std::pair(key, value), was);
  }

  void Real(const char* key, double& value, Range range, const char* help) override {
    Line(key, fmt::format("{}", value), fmt::format("{}; {}", help, RangeText(range)));
  }
  void Integer(const char* key, int& value, Range range, const char* help) override {
    Line(key, fmt::format("{}", value), fmt::format("{}; {}", help, RangeText(range)));
  }
  void Seed(const char* key, uint64_t& value, const char* help) override {
    Line(key, fmt::format("{}", value), help);
  }
  void Bool(const char* key, bool& value, const char* help) override {
    Line(key, value ? "true" : "false", help);
  }
  void Text(const char* key, std::string& value, const std::vector<std::string>& choices,
            const char* help) override {
    std::string text = help;
    if (!choices.empty()) text += fmt::format("; {}", fmt::join(choices, " | "));
    const auto former = former_values_.back().find({key, value});
    Line(key, Quoted(former == former_values_.back().end() ? value : former->second), text);
  }
  void Names(const char* key, std::vector<std::string>& value, const char* help) override {
    std::vector<std::string> quoted;
    for (const std::string& name : value) quoted.push_back(Quoted(name));
    Line(key, value.size() == 1 ? quoted[0] : fmt::format("[{}]", fmt::join(quoted, ", ")), help);
  }
  void Words(const char* key, std::vector<std::string>& value, const char* help) override {
    std::vector<std::string> quoted;
    for (const std::string& word : value) quoted.push_back(Quoted(word));
    Line(key, fmt::format("[{}]", fmt::join(quoted, ", ")), help);
  }
  void Vector2(const char* key, Eigen::Vector2d& value, Range range, const char* help) override {
    Line(key, fmt::format("[{}, {}]", value[0], value[1]),
         fmt::format("{}; each {}", help, RangeText(range)));
  }
  void Vector3(const char* key, Eigen::Vector3d& value, Range range, const char* help) override {
    Line(key, fmt::format("[{}, {}, {}]", value[0], value[1], value[2]),
         fmt::format("{}; each {}", help, RangeText(range)));
  }
  void Group(const char* key, const VisitFunction& visit, const char* help) override {
    Line(key, "", help);
    ++depth_;
    Enter();
    visit(*this);
    Leave();
    --depth_;
  }
  void List(const char* key, size_t size, const std::function<void(size_t)>&,
            const std::function<void(size_t, SettingsVisitor&)>& visit, const char* help) override {
    Line(key, size == 0 ? "[]" : "", help);
    for (size_t i = 0; i < size; ++i) {
      depth_ += 2;
      starts_item_ = true;
      Enter();
      visit(i, *this);
      Leave();
      depth_ -= 2;
    }
  }

  std::string text() const { return text_; }

 private:
  void Enter() {
    former_keys_.emplace_back();
    former_values_.emplace_back();
  }
  void Leave() {
    former_keys_.pop_back();
    former_values_.pop_back();
  }

  static std::string Quoted(const std::string& value) {
    YAML::Emitter out;
    out << YAML::DoubleQuoted << value;
    return out.c_str();
  }

  void Line(const char* key, const std::string& value, const std::string& help) {
    std::string indent(2 * depth_, ' ');
    if (starts_item_) indent.replace(indent.size() - 2, 2, "- ");
    starts_item_ = false;
    const auto former = former_keys_.back().find(key);
    text_ += indent + (former == former_keys_.back().end() ? key : former->second) + ":" +
             (value.empty() ? "" : " " + value);
    if (with_help_) text_ += "  # " + help;
    text_ += "\n";
  }

  bool with_help_;
  bool former_;
  // Names of earlier versions in the map under way and in the maps around it.
  std::vector<std::map<std::string, std::string>> former_keys_{1};
  std::vector<std::map<std::pair<std::string, std::string>, std::string>> former_values_{1};
  int depth_ = 0;
  bool starts_item_ = false;
  std::string text_;
};

KeyPlaces Read(const CurrentText& yaml, const std::string& name_for_errors,
               const VisitFunction& visit) {
  Reader reader(ParseYaml(yaml.text, name_for_errors), name_for_errors, true);
  visit(reader);
  reader.RejectUnknownKeys();
  return reader.places();
}

}  // namespace

KeyPlaces ReadSettingsText(const std::string& yaml, const std::string& name_for_errors,
                           const VisitFunction& visit) {
  return Read(WithCurrentNames(yaml, visit), name_for_errors, visit);
}

KeyPlaces ReadSettingsFile(const std::filesystem::path& file, const VisitFunction& visit) {
  CheckInput(IsRegularFile(file), fmt::format("{}: cannot be read; check the path", file.string()));
  const std::string text = ReadFileBytes(file);
  ParseYaml(text, file.string());  // its errors name the file
  RequireWholeYaml(text, file.string());
  const CurrentText yaml = WithCurrentNames(text, visit);
  KeyPlaces places = Read(yaml, file.string(), visit);
  CheckInput(!places.empty(), fmt::format("{}: the file has no settings, so it may be cut short; "
                                          "get it again, or write at least one setting",
                                          file.string()));
  if (!yaml.replaced.empty()) ReportDeprecation(DeprecationLine(file.string(), yaml.replaced));
  return places;
}

KeyPlaces ApplySetting(const std::string& given, const VisitFunction& visit) {
  const std::string source = kAssignmentPlace + given;
  const CurrentText current = AssignmentWithCurrentNames(given, visit);
  const std::string& assignment = current.text;
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InputError(fmt::format("{}: expected key=value, such as bin.wall_m=0.004", source));
  }
  if (assignment[equals - 1] == '.') {
    throw InputError(fmt::format("{}: the key ends with a dot; write the whole key", source));
  }
  YAML::Node value = ParseYaml(assignment.substr(equals + 1), source);
  std::vector<std::string> keys;
  std::stringstream path(assignment.substr(0, equals));
  for (std::string key; std::getline(path, key, '.');) keys.push_back(key);
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
    YAML::Node parent(YAML::NodeType::Map);
    parent[*key] = value;
    value = parent;
  }
  Reader reader(value, source, false);
  visit(reader);
  reader.RejectUnknownKeys();
  if (!current.replaced.empty()) {
    ReportDeprecation(fmt::format("setting '{}' is deprecated, write '{}'", given, assignment));
  }
  return reader.places();
}

std::string WriteSettings(const VisitFunction& visit, bool with_help) {
  Writer writer(with_help);
  visit(writer);
  return writer.text();
}

std::string WriteSettingsKey(const VisitFunction& visit) {
  Writer writer(/*with_help=*/false, Writer::Names::kFormer);
  visit(writer);
  return writer.text();
}

}  // namespace pickbed::scenes
