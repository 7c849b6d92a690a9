// Reads the inputs of a trial from its store.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "eval/replay/replay.h"
#include "eval/store/schema.h"
#include "eval/store/store_check.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "scenes/base/error.h"
#include "scenes/base/ids_format.h"
#include "scenes/scenario/find_scenario.h"
#include "scenes/scenario/load_objects.h"

namespace pickbed::eval {
namespace {

constexpr char kTrialListRow[] = "{:>6}{:>6}{:>10}{:>11}  {}\n";

std::string Named(const TrialAddress& address) {
  return fmt::format("{}#{}", address.run.string(), address.trial);
}

// Returns the configuration of a trial. A recorded trial has its number; for another trial, the
// trial ranges decide.
const StoredConfiguration& ConfigurationOf(const ResultsStore& store, const TrialAddress& address,
                                           std::optional<int> number) {
  for (const StoredConfiguration& configuration : store.head().configurations) {
    const int within = address.trial - configuration.first_trial;
    if (number ? configuration.number == *number : within >= 0 && within < configuration.trials)
      return configuration;
  }
  throw InputError(fmt::format("{}: the run has no such trial", Named(address)));
}

// Returns the recorded settings. Stores of schema 4 do not hold them separately; then scenario.yaml
// in the folder is used.
ScenarioSpec SpecOf(const StoredConfiguration& configuration, const TrialAddress& address) {
  if (configuration.settings != configuration.identity) {
    return LoadScenarioText(configuration.settings, address.run,
                            fmt::format("settings of {}", Named(address)));
  }
  const std::filesystem::path file = address.run / kScenarioFile;
  CheckInput(std::filesystem::exists(file),
             fmt::format("{} is missing, and the store has an older version without the settings; "
                         "put the file back",
                         file.string()));
  return LoadScenario(file);
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const size_t first = line.find_first_not_of(" -");
    if (first != std::string::npos) lines.push_back(line.substr(first));
  }
  return lines;
}

// Returns the entries of `lines` that are not in `others`, in order; duplicates are counted.
std::vector<std::string> Without(const std::vector<std::string>& lines,
                                 const std::vector<std::string>& others) {
  std::multiset<std::string> left(others.begin(), others.end());
  std::vector<std::string> result;
  for (const std::string& line : lines) {
    const auto same = left.find(line);
    if (same == left.end()) {
      result.push_back(line);
    } else {
      left.erase(same);
    }
  }
  return result;
}

// Returns the key of a line: "friction" for "friction: 0.5", "# part rod" for "# part rod is 0123".
std::string KeyOf(const std::string& line) {
  if (line.starts_with("# part ")) return line.substr(0, line.rfind(" is "));
  if (line.starts_with('#')) return line.substr(0, line.find(' ', 2));
  return line.substr(0, line.find(':'));
}

std::string ChangeOf(const std::string& was, const std::string& is) {
  const std::string key = KeyOf(was.empty() ? is : was);
  if (key.starts_with("# part ")) return key.substr(2) + ": mesh or physical properties";
  if (key == "# bin") return "the mesh of the bin";
  if (key == "# model") return is.empty() ? "the model is missing" : "the model of the estimator";
  if (key == "# completion") {
    return is.empty() ? "the model of shape completion is missing"
                      : "the model of shape completion";
  }
  if (was.empty()) return fmt::format("'{}' is new", is);
  return is.empty() ? fmt::format("'{}' is gone", was) : fmt::format("was '{}', is '{}'", was, is);
}

// Identities are settings, one line per key, and one hash line per file.
std::vector<std::string> ChangesBetween(const std::string& recorded, const std::string& now) {
  const std::vector<std::string> before = LinesOf(recorded), after = LinesOf(now);
  std::vector<std::string> added = Without(after, before);
  std::vector<std::string> changes;
  for (const std::string& was : Without(before, after)) {
    const auto is = std::find_if(added.begin(), added.end(), [&](const std::string& line) {
      return KeyOf(line) == KeyOf(was);
    });
    changes.push_back(ChangeOf(was, is == added.end() ? "" : *is));
    if (is != added.end()) added.erase(is);
  }
  for (const std::string& is : added) changes.push_back(ChangeOf("", is));
  return changes;
}

}  // namespace

std::string TrialList(const std::filesystem::path& run) {
  const ResultsStore store = ResultsStore::OpenToRead(run);
  const std::vector<SettingsCounts> counts = SettingsCountsOf(store.head(), run);
  std::map<int, std::string> lines;
  store.ForEach([&](const TrialResult& trial) {
    std::string status = kFinished;
    try {
      CheckTrial(trial, counts.at(static_cast<size_t>(trial.configuration)),
                 (run / kStoreFile).string());
    } catch (const InputError& error) {
      status = fmt::format("damaged: {}", error.what());
    }
    const auto successes = std::count_if(
        trial.attempts.begin(), trial.attempts.end(), [](const AttemptRecord& record) {
          return record.grasp && record.failure == FailureReason::kNone;
        });
    lines[trial.trial] = fmt::format(kTrialListRow, trial.trial, trial.bin_index,
                                     trial.attempts.size(), successes, status);
  });
  for (const CrashedTrial& trial : store.Crashed()) {
    lines[trial.trial] = fmt::format(kTrialListRow, trial.trial, trial.bin_index, 0, 0, kCrashed);
  }
  std::string text = fmt::format(kTrialListRow, "trial", "bin", "attempts", "successes", "status");
  for (const auto& [trial, line] : lines) text += line;
  return text;
}

void RequireProgramsAllowed(const ScenarioSpec& spec, const std::string& results, bool allowed) {
  std::vector<std::string> used;
  for (const auto* command : {&spec.estimator.command, &spec.planner.command}) {
    if (!command->empty()) used.push_back(fmt::format("'{}'", fmt::join(*command, " ")));
  }
  for (const std::string& server : {spec.estimator.connect, spec.planner.connect}) {
    if (!server.empty()) used.push_back(server);
  }
  CheckInput(allowed || used.empty(),
             fmt::format("{}: its settings use {}; allow it (--programs) if these results are "
                         "your own",
                         results, fmt::join(used, " and ")));
}

RecordedTrial ReadRecordedTrial(const TrialAddress& address, const std::string& catalog) {
  CheckInput(std::filesystem::is_directory(address.run),
             fmt::format("{}: there is no folder {}; name the results folder of a `pickbed run` or "
                         "`pickbed sweep`",
                         Named(address), address.run.string()));
  const ResultsStore store = ResultsStore::OpenToRead(address.run);
  RecordedTrial recorded;
  std::optional<int> number;
  for (TrialResult& trial : store.Read(address.trial, address.trial + 1)) {
    number = trial.configuration;
    recorded.result = std::move(trial);
  }
  for (const CrashedTrial& crashed : store.Crashed()) {
    if (crashed.trial != address.trial) continue;
    number = crashed.configuration;
    recorded.crashed = crashed;
    recorded.result.trial = crashed.trial;
    recorded.result.configuration = crashed.configuration;
    recorded.result.bin_index = crashed.bin_index;
  }
  const StoredConfiguration& configuration = ConfigurationOf(store, address, number);
  CheckInput(
      number.has_value(),
      fmt::format("{}: this trial is not finished; resume the run to finish it", Named(address)));
  try {
    recorded.spec = SpecOf(configuration, address);
    recorded.objects = LoadObjects(recorded.spec, OpenCatalog(catalog));
    recorded.truth = TruthIn(configuration.identity);
    recorded.changes = ChangesBetween(configuration.identity,
                                      RunIdentity(recorded.spec, recorded.objects, recorded.truth));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} cannot be replayed: {}", Named(address), error.what()));
  }
  CheckTrial(recorded.result, {recorded.objects.size(), recorded.spec.occlusion.bands.size()},
             (address.run / kStoreFile).string());
  return recorded;
}

}  // namespace pickbed::eval
