#include "eval/store/former_names.h"

#include <fmt/format.h>

#include <map>
#include <regex>
#include <sstream>

#include "scenes/base/random.h"
#include "scenes/base/settings_names.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {
namespace {

// Lines at which the scenario in an identity begins and ends. The settings of the gripper follow.
constexpr std::string_view kScenarioBegins = "seed: ";
constexpr std::string_view kScenarioEnds = "mechanism: ";

// A complete scenario also gets the keys that a later version added, with their defaults.
std::string ScenarioWithCurrentNames(const std::string& yaml) {
  constexpr std::string_view kLastGroup = "\ncycle:\n";
  ScenarioSpec spec;
  const auto visit = [&](SettingsVisitor& v) { spec.Visit(v); };
  const std::string text = scenes::WithCurrentNames(yaml, visit).text;
  if (text.find(kLastGroup) == std::string::npos) return text;
  ReadSettingsText(text, "settings of the store", visit);
  return WriteSettings(visit);
}

std::string HashText(const std::string& text) {
  return fmt::format("{:016x}", HashBytes(text.data(), text.size()));
}

// Updates the identity of a sweep, or of several merged stores. It has one line per configuration
// of a sweep, with the hash of its identity, and the whole identity of each run.
std::string HeadWithCurrentNames(const StoreHead& head) {
  std::map<std::string, std::string> hashes;  // before -> now
  for (const StoredConfiguration& configuration : head.configurations) {
    hashes[HashText(configuration.identity)] = HashText(WithCurrentNames(configuration.identity));
  }
  static const std::regex kLine(
      "(?:point|configuration) ([0-9]+) has ([0-9]+) trials ([0-9a-f]{16}): (.*)");
  std::string text, run;
  std::istringstream lines(head.identity);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, kLine)) {
      run += line + "\n";
      continue;
    }
    const auto hash = hashes.find(match[3]);
    text += WithCurrentNames(run);
    run.clear();
    text += ConfigurationIdentity(std::stoi(match[1]), std::stoi(match[2]),
                                  hash == hashes.end() ? match[3].str() : hash->second,
                                  NameWithCurrentNames(match[4]));
  }
  // A text without lines of a sweep is one run or several merged ones; its last line end is kept.
  return text.empty() ? WithCurrentNames(head.identity) : text + WithCurrentNames(run);
}

}  // namespace

std::string WithCurrentNames(const std::string& identity) {
  std::string text, scenario;
  std::istringstream lines(identity);
  bool in_scenario = false;
  const auto end_scenario = [&] {
    text += ScenarioWithCurrentNames(scenario);
    scenario.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    if (!lines.eof() || identity.ends_with('\n')) line += '\n';
    if (line.starts_with(kScenarioBegins)) {
      end_scenario();
      in_scenario = true;
    }
    if (in_scenario && line.starts_with(kScenarioEnds)) {
      end_scenario();
      in_scenario = false;
    }
    (in_scenario ? scenario : text) += line;
  }
  end_scenario();
  return text;
}

std::string NameWithCurrentNames(const std::string& name) {
  std::string text;
  std::istringstream assignments(name);
  for (std::string assignment; std::getline(assignments, assignment, ',');) {
    ScenarioSpec spec;
    const auto visit = [&](SettingsVisitor& v) { spec.Visit(v); };
    const size_t colon =
        assignment.substr(0, assignment.find('=')).rfind(':');  // after the name of a merged run
    const size_t begin = colon == std::string::npos ? 0 : colon + 1;
    text += (text.empty() ? "" : ",") + assignment.substr(0, begin) +
            AssignmentWithCurrentNames(assignment.substr(begin), visit).text;
  }
  return text;
}

StoreHead WithCurrentNames(const StoreHead& head) {
  StoreHead current;
  current.identity = HeadWithCurrentNames(head);
  for (StoredConfiguration configuration : head.configurations) {
    configuration.name = NameWithCurrentNames(configuration.name);
    configuration.identity = WithCurrentNames(configuration.identity);
    configuration.settings = WithCurrentNames(configuration.settings);
    current.configurations.push_back(std::move(configuration));
  }
  return current;
}

}  // namespace pickbed::eval
