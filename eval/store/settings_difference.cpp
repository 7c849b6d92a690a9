#include "eval/store/settings_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

namespace pickbed::eval {
namespace {

constexpr char kNothing[] = "nothing";

// Values by key, in the order of the text. A key that occurs twice has two values.
struct Values {
  std::vector<std::string> keys;
  std::map<std::string, std::vector<std::string>> of_key;

  void Add(const std::string& key, const std::string& value) {
    auto& values = of_key[key];
    if (values.empty()) keys.push_back(key);
    values.push_back(value);
  }
};

// A key that is open while its deeper lines are read.
struct OpenKey {
  size_t indent = 0;
  std::string name;
  int items = 0;  // of its list so far
};

// "# part rod is 0123" has the key "# part rod".
void AddHash(const std::string& line, Values& values) {
  const size_t at = line.rfind(' ');
  std::string key = line.substr(0, at);
  if (key.ends_with(" is")) key.resize(key.size() - 3);
  values.Add(key, line.substr(at + 1));
}

std::string PathOf(const std::vector<OpenKey>& open, const std::string& key) {
  std::string path;
  for (const OpenKey& outer : open) {
    path += outer.name + ".";
    if (outer.items > 0) path += fmt::format("{}.", outer.items - 1);
  }
  return path + key;
}

Values ValuesOf(const std::string& text) {
  Values values;
  std::vector<OpenKey> open;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) {
      AddHash(line, values);
      continue;
    }
    size_t at = line.find_first_not_of(' ');
    if (at == std::string::npos) continue;
    const bool is_item = line.compare(at, 2, "- ") == 0;
    while (!open.empty() && (open.back().indent > at || (open.back().indent == at && !is_item))) {
      open.pop_back();
    }
    if (is_item) {
      if (!open.empty()) ++open.back().items;
      at += 2;
    }
    const size_t colon = line.find(':', at);
    if (colon == std::string::npos) {
      values.Add(PathOf(open, ""), line.substr(at));
      continue;
    }
    const std::string key = line.substr(at, colon - at);
    const size_t value = line.find_first_not_of(' ', colon + 1);
    if (value == std::string::npos) {
      open.push_back({at, key, 0});
    } else {
      values.Add(PathOf(open, key), line.substr(value));
    }
  }
  return values;
}

// Returns what a hash describes; empty for a setting.
std::string HashedThing(const std::string& key) {
  constexpr std::string_view kObject = "# part ";
  if (key.starts_with(kObject)) {
    return fmt::format("mesh or mass of object {}", key.substr(kObject.size()));
  }
  if (key.starts_with("# bin")) return "mesh of the bin";
  if (key.starts_with("# model")) return "trained model";
  if (key.starts_with("# truth")) return "stages with ground truth";
  if (key.starts_with("# calibration")) return "calibration of the scores";
  if (key.starts_with("# completion")) return "model of shape completion";
  if (key.starts_with("# program")) return "program of the estimator or planner";
  if (key.starts_with("# estimator")) return "program that answers for the estimator";
  if (key.starts_with("# images of the dataset")) return "list of the target images";
  if (key.starts_with("# cameras of the dataset")) return "list of the cameras";
  if (key.starts_with("# mask")) return "mask of the region of interest";
  if (key.starts_with("# meshes of the dataset")) return "meshes of the dataset";
  if (key.starts_with("# cell of the dataset")) return "bin of the dataset";
  if (key.starts_with("# planner")) return "program that answers for the planner";
  return "";
}

// Returns the difference of one value in words.
std::string InWords(const std::string& key, const std::string& was, const std::string& is) {
  if (key.starts_with("# grasps chosen")) {
    return is == kNothing ? "the stored run has grasps of a caller, this one has none"
                          : "this run has grasps of a caller, the stored one has none";
  }
  const std::string thing = HashedThing(key);
  if (!thing.empty()) return thing + " has changed";
  const std::string name = key.starts_with("# ") ? key.substr(2) : key;
  return fmt::format("{}: {} before, {} now", name, was, is);
}

}  // namespace

std::vector<SettingDifference> DifferentSettings(const std::string& before,
                                                 const std::string& now) {
  const Values old_values = ValuesOf(before), new_values = ValuesOf(now);
  std::vector<std::string> keys = old_values.keys;
  for (const std::string& key : new_values.keys) {
    if (!old_values.of_key.contains(key)) keys.push_back(key);
  }
  std::vector<SettingDifference> differences;
  for (const std::string& key : keys) {
    const auto was = old_values.of_key.find(key), is = new_values.of_key.find(key);
    const size_t count_was = was == old_values.of_key.end() ? 0 : was->second.size();
    const size_t count_is = is == new_values.of_key.end() ? 0 : is->second.size();
    for (size_t i = 0; i < std::max(count_was, count_is); ++i) {
      const std::string value_was = i < count_was ? was->second[i] : kNothing;
      const std::string value_is = i < count_is ? is->second[i] : kNothing;
      if (value_was != value_is) differences.push_back({key, value_was, value_is});
    }
  }
  return differences;
}

std::string SettingInWords(const std::string& key) {
  if (key.starts_with("# grasps chosen")) return "grasps of a caller";
  const std::string thing = HashedThing(key);
  return thing.empty() ? key : thing;
}

std::vector<std::string> SettingsDifferences(const std::string& before, const std::string& now) {
  std::vector<std::string> texts;
  for (const SettingDifference& difference : DifferentSettings(before, now)) {
    texts.push_back(InWords(difference.key, difference.before, difference.now));
  }
  return texts;
}

}  // namespace pickbed::eval
