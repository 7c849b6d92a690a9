#include "eval/sweep/sweep_spec.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "eval/sweep/run.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/settings_names.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {
namespace {

constexpr size_t kLongestName = 60;  // characters of a setting in a name; longer ones are shortened
constexpr int kMaxConfigurations = 10000;

constexpr std::array<SweepKey, 6> kSweepKeys{{
    {"scenario", "text", "name of a preset, or a scenario file relative to this file; required"},
    {"trials", "whole number from 1 to 1000000",
     "number of bins per configuration; default: as in the "
     "scenario"},
    {"set", "map of settings", "settings of all configurations, with the keys of a scenario file"},
    {"grid", "map of lists",
     "settings that are varied; the sweep runs every combination, and the first key varies "
     "slowest"},
    {"occlusion", "map of settings", "settings of the scenario group occlusion"},
    {"slurm", "map of settings", "settings of `pickbed sweep --slurm`"},
}};

using Kind = SettingsTree::Kind;

[[noreturn]] void Fail(const SettingsTree& entry, const std::string& what) {
  throw InputError(fmt::format("{}: {} = {}: {}", entry.place, entry.key, entry.text, what));
}

std::string ShortName(const std::string& assignment) {
  return assignment.size() <= kLongestName ? assignment
                                           : assignment.substr(0, kLongestName - 3) + "...";
}

// The whole number that is the entire text, if it is one of 64 bits.
std::optional<int64_t> WholeNumber(std::string_view text) {
  int64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [after, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && after == end ? std::optional(number) : std::nullopt;
}

// Expands "1..3" to 1, 2, 3; empty if the text is not a range.
std::vector<std::string> RangeOf(const SettingsTree& entry) {
  constexpr std::string_view kDots = "..";
  const std::string_view text = entry.text;
  const size_t dots = text.find(kDots);
  if (dots == std::string_view::npos) return {};
  const std::optional<int64_t> from = WholeNumber(text.substr(0, dots));
  const std::optional<int64_t> to = WholeNumber(text.substr(dots + kDots.size()));
  if (!from || !to) return {};
  if (*from > *to) Fail(entry, "must be ascending, for example 1..10");
  // Unsigned, because the difference of two numbers can exceed 64 bits.
  const uint64_t steps = static_cast<uint64_t>(*to) - static_cast<uint64_t>(*from);
  if (steps >= kMaxConfigurations) {
    Fail(entry, fmt::format("has more than {} values", kMaxConfigurations));
  }
  std::vector<std::string> numbers;
  for (uint64_t step = 0; step <= steps; ++step) {
    numbers.push_back(std::to_string(*from + static_cast<int64_t>(step)));
  }
  return numbers;
}

GridValue ValueOf(const std::string& key, const SettingsTree& item) {
  GridValue value;
  if (item.kind == Kind::kMap) {
    value.settings = SettingsIn(item);
  } else {
    value.settings = {{fmt::format("{}={}", key, item.text), item.place}};
  }
  for (const PlacedSetting& setting : value.settings) {
    if (!value.name.empty()) value.name += ',';
    value.name += ShortName(setting.assignment);
  }
  return value;
}

// Axis whose values have user-defined labels.
GridAxis LabelledAxis(const SettingsTree& entry) {
  if (entry.items.empty()) Fail(entry, "has no value; write LABEL: {KEY: VALUE}");
  GridAxis axis{entry.key, {}};
  for (const SettingsTree& item : entry.items) {
    if (item.kind != Kind::kMap || item.items.empty()) {
      Fail(item, "a label needs settings, for example ppf: {estimator.name: ppf}");
    }
    axis.values.push_back({entry.key + "=" + item.key, SettingsIn(item)});
  }
  return axis;
}

GridAxis AxisOf(const SettingsTree& entry) {
  GridAxis axis{entry.key, {}};
  for (const std::string& number : RangeOf(entry)) {
    const std::string assignment = entry.key + "=" + number;
    axis.values.push_back({assignment, {{assignment, entry.place}}});
  }
  if (!axis.values.empty()) return axis;
  if (entry.kind == Kind::kMap) return LabelledAxis(entry);
  if (entry.kind != Kind::kList) {
    Fail(entry, "must be a list of values, for example [a, b], or a range of whole numbers, 1..10");
  }
  if (entry.items.empty()) Fail(entry, "the list is empty; add at least one value, or remove it");
  for (const SettingsTree& item : entry.items) {
    if (item.kind == Kind::kMap && item.items.empty()) Fail(item, "has no settings");
    GridValue value = ValueOf(entry.key, item);
    for (const GridValue& other : axis.values) {
      CheckInput(other.name != value.name,
                 fmt::format("{}: {}: is in the grid twice; remove one", item.place, value.name));
    }
    axis.values.push_back(std::move(value));
  }
  return axis;
}

std::string KeyOf(const PlacedSetting& setting) {
  return setting.assignment.substr(0, setting.assignment.find('='));
}

// Returns whether the two keys set a common setting, such as "policy" and "policy.stop".
bool Overlap(const std::string& a, const std::string& b) {
  return a == b || a.starts_with(b + ".") || b.starts_with(a + ".");
}

// Returns the first setting of the axis that overlaps with `key`, or null.
const PlacedSetting* SettingOf(const GridAxis& axis, const std::string& key) {
  for (const GridValue& value : axis.values) {
    for (const PlacedSetting& setting : value.settings) {
      if (Overlap(KeyOf(setting), key)) return &setting;
    }
  }
  return nullptr;
}

// Settings of the axes read so far: key, and the axis that sets it.
using AxisOfKey = std::map<std::string, std::string, std::less<>>;

// Returns the entry whose key overlaps with `key`, or the end. Logarithmic, because a grid can have
// thousands of keys.
AxisOfKey::const_iterator OverlappingKey(const AxisOfKey& axis_of_key, const std::string& key) {
  for (size_t end = key.find('.'); end < key.size(); end = key.find('.', end + 1)) {
    const auto group = axis_of_key.find(std::string_view(key).substr(0, end));
    if (group != axis_of_key.end()) return group;
  }
  const auto same = axis_of_key.find(key);
  if (same != axis_of_key.end()) return same;
  const auto inside = axis_of_key.lower_bound(key + ".");
  const bool overlaps = inside != axis_of_key.end() && Overlap(inside->first, key);
  return overlaps ? inside : axis_of_key.end();
}

// Refuses a key that an earlier axis sets. Otherwise the later axis would win, and the names of
// configurations would be wrong.
void RequireApart(const GridAxis& axis, const AxisOfKey& earlier) {
  for (const GridValue& value : axis.values) {
    for (const PlacedSetting& setting : value.settings) {
      const auto other = OverlappingKey(earlier, KeyOf(setting));
      if (other == earlier.end()) continue;
      throw InputError(fmt::format("{}: {}: {} also sets {}; keep only one of them", setting.place,
                                   setting.assignment, other->second, other->first));
    }
  }
}

std::vector<GridAxis> GridOf(const SettingsTree& grid) {
  if (grid.kind != Kind::kMap || grid.items.empty()) {
    Fail(grid,
         "the grid is empty; add a setting and its values, for example sensor: [ideal, "
         "time_of_flight]");
  }
  std::vector<GridAxis> axes;
  AxisOfKey axis_of_key;
  size_t configurations = 1;
  for (const SettingsTree& entry : grid.items) {
    GridAxis axis = AxisOf(entry);
    RequireApart(axis, axis_of_key);
    for (const GridValue& value : axis.values) {
      for (const PlacedSetting& setting : value.settings) {
        axis_of_key.emplace(KeyOf(setting), axis.key);
      }
    }
    axes.push_back(std::move(axis));
    configurations *= axes.back().values.size();
    if (configurations > kMaxConfigurations)
      Fail(entry, fmt::format("gives over {} configurations", kMaxConfigurations));
  }
  return axes;
}

int TrialsOf(const SettingsTree& entry) {
  constexpr int kMaxTrials = 1000000;  // as in a scenario
  const std::optional<int64_t> trials = WholeNumber(entry.text);
  if (!trials || *trials < 1 || *trials > kMaxTrials) {
    Fail(entry,
         fmt::format("must be a whole number from 1 to {} (bins per configuration)", kMaxTrials));
  }
  return static_cast<int>(*trials);
}

// A file next to the sweep file takes precedence over a preset.
std::string ScenarioOf(const SettingsTree& entry, const std::filesystem::path& file) {
  const std::filesystem::path beside =
      std::filesystem::absolute(file).parent_path() / std::filesystem::path(entry.text);
  if (entry.kind == Kind::kValue && IsRegularFile(beside)) {
    return beside.lexically_normal().string();
  }
  const std::vector<std::string> presets = PresetNames();
  if (std::find(presets.begin(), presets.end(), entry.text) == presets.end()) {
    throw InputError(fmt::format("{}: {} (there is no such file either: {})", entry.place,
                                 UnknownNameMessage("scenario", entry.text, presets),
                                 beside.string()));
  }
  return entry.text;
}

// Replaces former names in a tree of scenario settings such as a sweep file.
class NameUpdate {
 public:
  // Names found so far, with their lines in the file.
  const std::vector<ReplacedName>& replaced() const { return replaced_; }

  // Updates the keys and values of a map of settings; `prefix` is the group that they belong to.
  void UpdateSettings(const std::string& prefix, SettingsTree& map) {
    for (SettingsTree& entry : map.items) {
      const auto [key, value] = Update(prefix + entry.key, entry);
      entry.key = key.substr(prefix.size());
      entry.text = value;
    }
    UpdateText(map);
  }

  void UpdateGrid(SettingsTree& grid) {
    for (SettingsTree& axis : grid.items) {
      std::string key = axis.key;
      for (SettingsTree& item : axis.items) {
        if (item.kind == Kind::kMap) {  // settings of a label, or settings that are their own label
          UpdateSettings("", item);
        } else {
          std::tie(key, item.text) = Update(axis.key, item);
        }
      }
      if (axis.kind == Kind::kValue) std::tie(key, axis.text) = Update(axis.key, axis);
      axis.key = key;
      UpdateText(axis);
    }
    UpdateText(grid);
  }

 private:
  // Returns key and value of a setting with the names of now.
  std::pair<std::string, std::string> Update(const std::string& key, const SettingsTree& value) {
    ScenarioSpec spec;
    const CurrentText current = AssignmentWithCurrentNames(
        key + "=" + value.text, [&](SettingsVisitor& v) { spec.Visit(v); });
    for (ReplacedName name : current.replaced) {
      name.line = std::atoi(value.place.substr(value.place.rfind(':') + 1).c_str());
      const bool known = std::any_of(
          replaced_.begin(), replaced_.end(),
          [&](const ReplacedName& other) { return other.was == name.was && other.is == name.is; });
      if (!known) replaced_.push_back(name);
    }
    const size_t equals = current.text.find('=');
    return {current.text.substr(0, equals), current.text.substr(equals + 1)};
  }

  // Makes the text of a map or list again after its items were updated.
  void UpdateText(SettingsTree& tree) const {
    if (replaced_.empty() || tree.kind == Kind::kValue) return;
    std::string text;
    for (const SettingsTree& item : tree.items) {
      text += (text.empty() ? "" : ", ") + (item.key.empty() ? "" : item.key + ": ") + item.text;
    }
    tree.text = tree.kind == Kind::kMap ? "{" + text + "}" : "[" + text + "]";
  }

  std::vector<ReplacedName> replaced_;
};

// Updates a whole sweep file.
std::vector<ReplacedName> UpdateNames(SettingsTree& file) {
  NameUpdate update;
  for (SettingsTree& entry : file.items) {
    if (entry.key == "set") update.UpdateSettings("", entry);
    if (entry.key == "occlusion") update.UpdateSettings("occlusion.", entry);
    if (entry.key == "grid") update.UpdateGrid(entry);
  }
  return update.replaced();
}

std::string Joined(const std::vector<PlacedSetting>& settings) {
  std::string text;
  for (const PlacedSetting& setting : settings) {
    const size_t equals = setting.assignment.find('=');
    text += fmt::format("  {}: {}\n", setting.assignment.substr(0, equals),
                        setting.assignment.substr(equals + 1));
  }
  return text;
}

// SweepText writes the Slurm block last.
std::string WithoutSlurm(const std::string& yaml) { return yaml.substr(0, yaml.find("\nslurm:")); }

// Updates the result of a SweepText() of an earlier version.
std::string WithCurrentNames(const std::string& yaml) {
  SettingsTree tree = ReadSettingsTreeText(yaml, kSweepFile);
  if (UpdateNames(tree).empty()) return yaml;
  std::string text;
  for (const SettingsTree& entry : tree.items) {
    text += entry.key == "set" ? "set:\n" + Joined(SettingsIn(entry))
                               : fmt::format("{}: {}\n", entry.key, entry.text);
  }
  return text;
}

// The numbers of all trials of a sweep fit into an int.
void CheckTrials(int trials, size_t configurations, const std::string& sweep) {
  const size_t limit = std::numeric_limits<int>::max() / configurations;
  CheckInput(static_cast<size_t>(trials) <= limit,
             fmt::format("sweep {}: {} trials of each of {} configurations are too many; give at "
                         "most {} trials, or fewer values in the grid",
                         sweep, trials, configurations, limit));
}

}  // namespace

std::span<const SweepKey> SweepKeys() { return kSweepKeys; }

SweepSpec LoadSweepSpec(const std::filesystem::path& file) {
  std::vector<std::string> keys;
  for (const SweepKey& key : SweepKeys()) keys.push_back(key.name);
  SettingsTree tree = ReadSettingsTree(file);
  const std::vector<ReplacedName> replaced = UpdateNames(tree);
  if (!replaced.empty()) ReportDeprecation(DeprecationLine(file.string(), replaced));
  for (const SettingsTree& entry : tree.items) {
    CheckInput(std::find(keys.begin(), keys.end(), entry.key) != keys.end(),
               fmt::format("{}: {}", entry.place, UnknownNameMessage("key", entry.key, keys)));
  }
  SweepSpec spec;
  spec.name = file.stem().string();
  const SettingsTree* scenario = tree.Find("scenario");
  CheckInput(scenario != nullptr,
             fmt::format("{}: has no scenario; add 'scenario: demo'", file.string()));
  spec.scenario = ScenarioOf(*scenario, file);
  if (const SettingsTree* trials = tree.Find("trials")) spec.trials = TrialsOf(*trials);
  if (const SettingsTree* set = tree.Find("set")) spec.set = SettingsIn(*set);
  if (const SettingsTree* occlusion = tree.Find("occlusion")) {
    for (const PlacedSetting& setting : SettingsIn(*occlusion)) {
      spec.set.push_back({"occlusion." + setting.assignment, setting.place});
    }
  }
  if (const SettingsTree* slurm = tree.Find("slurm")) {
    ReadSettingsBlock(*slurm, [&](SettingsVisitor& v) { spec.slurm.Visit(v); });
    try {
      spec.slurm.Validate();
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", slurm->place, error.what()));
    }
  }
  const SettingsTree* grid = tree.Find("grid");
  CheckInput(grid != nullptr,
             fmt::format("{}: has no grid; add a setting and its values, for example 'grid: "
                         "{{sensor: [ideal, time_of_flight]}}', or use pickbed run",
                         file.string()));
  spec.grid = GridOf(*grid);
  spec.grid_text = grid->text;
  return spec;
}

void SetForAll(const std::string& assignment, SweepSpec& spec) {
  ScenarioSpec scenario;
  const CurrentText current =
      AssignmentWithCurrentNames(assignment, [&](SettingsVisitor& v) { scenario.Visit(v); });
  const PlacedSetting setting{current.text, kAssignmentPlace + assignment};
  if (!current.replaced.empty()) {
    ReportDeprecation(
        fmt::format("setting '{}' is deprecated, write '{}'", assignment, current.text));
  }
  for (const GridAxis& axis : spec.grid) {
    const PlacedSetting* duplicate = SettingOf(axis, KeyOf(setting));
    CheckInput(duplicate == nullptr,
               fmt::format("{}: the grid also sets {} ({}); change it there", setting.place,
                           duplicate ? KeyOf(*duplicate) : "", duplicate ? duplicate->place : ""));
  }
  std::erase_if(spec.set, [&](const PlacedSetting& old) { return KeyOf(old) == KeyOf(setting); });
  spec.set.push_back(setting);
}

std::vector<GridValue> GridConfigurations(const SweepSpec& spec) {
  size_t count = 1;
  for (const GridAxis& axis : spec.grid) count *= axis.values.size();
  std::vector<GridValue> configurations(count, {"", spec.set});
  size_t repeats = count;  // of a value of the axis in a row; the last axis varies fastest
  for (const GridAxis& axis : spec.grid) {
    repeats /= axis.values.size();
    for (size_t i = 0; i < count; ++i) {
      const GridValue& value = axis.values[i / repeats % axis.values.size()];
      GridValue& made = configurations[i];
      made.name += (made.name.empty() ? "" : ",") + value.name;
      made.settings.insert(made.settings.end(), value.settings.begin(), value.settings.end());
    }
  }
  return configurations;
}

Sweep MakeSweep(const SweepSpec& spec, const std::filesystem::path& out,
                const std::string& catalog) {
  Sweep sweep;
  sweep.yaml = SweepText(spec, out);
  const std::vector<GridValue> values = GridConfigurations(spec);
  // Before the scenarios are loaded, which takes about 20 ms each.
  if (spec.trials) CheckTrials(*spec.trials, values.size(), spec.name);
  int next_trial = 0;
  for (const GridValue& value : values) {
    Configuration& configuration = sweep.configurations.emplace_back();
    configuration.number = static_cast<int>(sweep.configurations.size()) - 1;
    configuration.name = value.name;
    ApplyPlaced(value.settings, [&](const std::vector<std::string>& assignments) {
      LoadedScenario loaded = FindScenario({spec.scenario, assignments, catalog, spec.trials});
      configuration.spec = std::move(loaded.spec);
      configuration.objects = std::move(loaded.objects);
      configuration.identity = RunIdentity(configuration.spec, configuration.objects);
      return true;
    });
    CheckTrials(configuration.spec.trials, values.size(), spec.name);
    configuration.first_trial = next_trial;
    configuration.trials = configuration.spec.trials;
    next_trial += configuration.trials;
  }
  return sweep;
}

std::string SweepText(const SweepSpec& spec, const std::filesystem::path& out) {
  const std::filesystem::path scenario = spec.scenario;
  std::string text = fmt::format(
      "scenario: {}\n",
      scenario.is_absolute() ? std::filesystem::relative(scenario, out).string() : spec.scenario);
  if (spec.trials) text += fmt::format("trials: {}\n", *spec.trials);
  if (!spec.set.empty()) text += "set:\n" + Joined(spec.set);
  text += fmt::format("grid: {}\n", spec.grid_text);
  SlurmOptions slurm = spec.slurm;
  const std::string block = WriteSettings([&](SettingsVisitor& v) {
    v.Group(
        "slurm", [&](SettingsVisitor& group) { slurm.Visit(group); }, "");
  });
  return text + block;
}

void RequireNoOtherSweep(const std::filesystem::path& out, const std::string& yaml) {
  const std::filesystem::path file = out / kSweepFile;
  if (!IsRegularFile(file)) return;
  CheckInput(WithoutSlurm(WithCurrentNames(ReadFileBytes(file))) == WithoutSlurm(yaml),
             fmt::format("{} belongs to a sweep with other settings; choose another results folder",
                         file.string()));
}

}  // namespace pickbed::eval
