#include "scenes/base/settings_tree.h"

#include <fmt/format.h>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/base/yaml.h"

namespace pickbed::scenes {
namespace {

// Sets every level explicitly, because a node that was read from several lines keeps that style.
void SetFlowStyle(YAML::Node node) {
  if (!node.IsMap() && !node.IsSequence()) return;
  node.SetStyle(YAML::EmitterStyle::Flow);
  for (const auto& entry : node) SetFlowStyle(node.IsMap() ? entry.second : entry);
}

std::string FlowText(const YAML::Node& node) {
  SetFlowStyle(node);
  YAML::Emitter out;
  out << node;
  return out.c_str();
}

SettingsTree ToTree(const YAML::Node& node, const std::string& source, const std::string& key) {
  SettingsTree tree;
  tree.key = key;
  tree.text = FlowText(node);
  tree.place = fmt::format("{}:{}", source, node.Mark().line + 1);
  if (node.IsSequence()) {
    tree.kind = SettingsTree::Kind::kList;
    for (const YAML::Node& item : node) tree.items.push_back(ToTree(item, source, ""));
  } else if (node.IsMap()) {
    tree.kind = SettingsTree::Kind::kMap;
    for (const auto& entry : node) {
      const std::string name = entry.first.as<std::string>("?");
      CheckInput(Printable(name) == name,
                 fmt::format("{}:{}: the key '{}' has a control character", source,
                             entry.first.Mark().line + 1, Printable(name)));
      const SettingsTree* before = tree.Find(name);
      SettingsTree item = ToTree(entry.second, source, name);
      CheckInput(before == nullptr,
                 fmt::format("{}: {} = {}: is given twice, before as {}; remove one", item.place,
                             name, item.text, before ? before->text : ""));
      tree.items.push_back(std::move(item));
    }
  }
  return tree;
}

}  // namespace

const SettingsTree* SettingsTree::Find(const std::string& name) const {
  for (const SettingsTree& item : items) {
    if (item.key == name) return &item;
  }
  return nullptr;
}

SettingsTree ReadSettingsTreeText(const std::string& yaml, const std::string& name_for_errors) {
  const YAML::Node node = ParseYaml(yaml, name_for_errors);
  CheckInput(node.IsMap(), fmt::format("{}: expected 'key: value' lines", name_for_errors));
  return ToTree(node, name_for_errors, "");
}

SettingsTree ReadSettingsTree(const std::filesystem::path& file) {
  CheckInput(IsRegularFile(file), fmt::format("{}: cannot be read; check the path", file.string()));
  return ReadSettingsTreeText(ReadFileBytes(file), file.string());
}

std::vector<PlacedSetting> SettingsIn(const SettingsTree& map) {
  CheckInput(map.kind == SettingsTree::Kind::kMap,
             fmt::format("{}: {} = {}: must be 'key: value' pairs", map.place, map.key, map.text));
  std::vector<PlacedSetting> settings;
  for (const SettingsTree& item : map.items) {
    settings.push_back({item.key + "=" + item.text, item.place});
  }
  return settings;
}

void ThrowPlaced(const std::vector<PlacedSetting>& settings, const std::exception& error) {
  if (dynamic_cast<const InputError*>(&error) == nullptr) throw;
  std::string message = error.what();
  for (const PlacedSetting& setting : settings) {
    const std::string given = kAssignmentPlace + setting.assignment;
    const size_t at = message.find(given);
    if (at != std::string::npos) message.replace(at, given.size(), setting.place);
  }
  throw InputError(message);
}

void ReadSettingsBlock(const SettingsTree& map, const VisitFunction& visit) {
  for (const PlacedSetting& setting : SettingsIn(map)) {
    ApplyPlaced({setting}, [&](const std::vector<std::string>& assignments) {
      return ApplySetting(assignments.front(), visit);
    });
  }
}

bool IsDamagedKey(std::string_view key, std::string_view known) {
  if (key.size() != known.size()) return false;
  int others = 0;
  for (size_t i = 0; i < key.size(); ++i) others += key[i] != known[i];
  return others == 1;
}

}  // namespace pickbed::scenes
