#include "eval/summary/result_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "eval/store/results_store.h"
#include "eval/summary/occlusion_sheet.h"
#include "scenes/base/files.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

constexpr size_t kLongestFileName = 120;

struct Csv {
  std::string trials, attempts, parts, timings;
};

// Appends a CSV table. Only the first table keeps its header line.
void Append(const std::string& text, std::string& csv) {
  csv += csv.empty() ? text : text.substr(text.find('\n') + 1);
}

std::vector<std::string> PartNames(const ScenarioSpec& spec) {
  std::vector<std::string> names;
  for (const PartSpec& part : spec.objects) names.push_back(part.name);
  return names;
}

ConfigurationSummary Summarized(const ResultsStore& store, const StoredConfiguration& configuration,
                                const std::vector<CrashedTrial>& all_crashed,
                                const std::filesystem::path& out, Csv& csv) {
  const bool alone = store.head().configurations.size() == 1;
  const ScenarioSpec spec =
      ScenarioOfText(configuration.settings, out, (out / "results.sqlite").string());
  const std::vector<std::string> names = PartNames(spec);
  const std::vector<TrialResult> trials =
      alone
          ? store.ReadAll()
          : store.Read(configuration.first_trial, configuration.first_trial + configuration.trials);
  ConfigurationSummary result{configuration,
                              Summarize(trials, spec.cycle, ReportedBands(spec.occlusion))};
  if (spec.occlusion.enabled) result.summary.bands = StatisticsByBand(trials, spec.occlusion);
  std::vector<CrashedTrial>& crashed = result.summary.crashed;
  std::copy_if(
      all_crashed.begin(), all_crashed.end(), std::back_inserter(crashed),
      [&](const CrashedTrial& trial) { return trial.configuration == configuration.number; });
  std::vector<int> crashed_bins;
  for (const CrashedTrial& trial : crashed) crashed_bins.push_back(trial.bin_index);
  result.summary.stop = StopOf(trials, crashed_bins, spec.stop_width);
  Append(TrialsCsv(trials, crashed), csv.trials);
  Append(AttemptsCsv(trials, names), csv.attempts);
  Append(InstanceOutcomesCsv(trials, names), csv.parts);
  Append(TimingsCsv(trials, alone ? result.summary.cycle : CycleTime()), csv.timings);
  return result;
}

// Returns a CSV cell, in quotes if the text holds a comma, a quote or a line break.
std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string ConfigurationsCsv(const std::vector<ConfigurationSummary>& configurations) {
  std::string csv =
      "point,name,seed,first_trial,trials,finished,crashed,attempts,successes,success_rate,"
      "success_low,success_high,instances_dropped,instances_cleared,frames,top1_correct\n";
  for (const auto& [configuration, s] : configurations) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", configuration.number,
                       Cell(configuration.name), configuration.seed, configuration.first_trial,
                       configuration.trials, s.trials, s.crashed.size(), s.executed_grasps,
                       s.successes, s.success_rate, s.success_ci95.low, s.success_ci95.high,
                       s.instances_dropped, s.instances_cleared, s.frames, s.top1_correct);
  }
  return csv;
}

void WriteCurve(const std::vector<ConfigurationSummary>& configurations,
                const std::filesystem::path& out) {
  std::vector<NamedCurve> curves;
  for (const auto& [configuration, summary] : configurations) {
    if (!summary.bands.empty()) curves.push_back({configuration.name, summary.bands});
  }
  if (curves.empty()) return;
  WriteFileAtomically(out / "curve.csv", CurveCsv(curves));
  WriteSeriesSheet(out / "pictures", curves.front().bands);
}

}  // namespace

std::string ConfigurationFileName(int configuration, const std::string& name) {
  std::string file = fmt::format("{:02}_{}", configuration, name);
  for (char& c : file) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || std::strchr("._-=,", c);
    if (!plain) c = '_';
  }
  return file.substr(0, kLongestFileName) + ".yaml";
}

std::string SweepTable(const std::vector<ConfigurationSummary>& configurations) {
  if (configurations.size() == 1 && configurations.front().configuration.name.empty()) {
    const ConfigurationSummary& run = configurations.front();
    return SummaryTable(run.summary);
  }
  size_t width = 5;
  for (const ConfigurationSummary& configuration : configurations)
    width = std::max(width, configuration.configuration.name.size());
  std::string text = fmt::format("{:<{}}  {:>11}  {:>23}  {:>9}  {:>11}\n", "Point", width, "bins",
                                 "picks that succeed", "cleared", "top-1 right");
  for (const auto& [configuration, s] : configurations) {
    const std::string rate =
        fmt::format("{} {}", PercentText(s.success_rate), IntervalText(s.success_ci95));
    text += fmt::format("{:<{}}  {:>5} of {:>2}  {:>23}  {:>9}  {:>11}{}\n", configuration.name,
                        width, s.trials, configuration.trials, rate, PercentText(s.cleared_rate),
                        PercentText(s.top1_precision),
                        s.crashed.empty() ? "" : fmt::format("  {} crashed", s.crashed.size()));
  }
  for (const auto& [configuration, summary] : configurations) {
    if (summary.stop) text += fmt::format("{}: {}\n", configuration.name, StopText(*summary.stop));
  }
  for (const auto& [configuration, summary] : configurations) {
    if (summary.bands.empty()) continue;
    text += fmt::format("\n{}\n{}", configuration.name, CurveTable(summary.bands));
  }
  return text;
}

std::string SweepJson(const std::vector<ConfigurationSummary>& configurations) {
  if (configurations.size() == 1 && configurations.front().configuration.name.empty()) {
    return SummaryJson(configurations.front().summary);
  }
  nlohmann::ordered_json json;
  json["points"] = nlohmann::ordered_json::array();
  for (const auto& [configuration, summary] : configurations) {
    nlohmann::ordered_json entry;
    entry["point"] = configuration.number;
    entry["name"] = configuration.name;
    entry.update(nlohmann::ordered_json::parse(SummaryJson(summary)));
    json["points"].push_back(std::move(entry));
  }
  return json.dump(2) + "\n";
}

std::vector<ConfigurationSummary> WriteSweepFiles(const std::filesystem::path& out) {
  const ResultsStore store = ResultsStore::OpenToRead(out);
  const std::vector<CrashedTrial> crashed = store.Crashed();
  std::vector<ConfigurationSummary> configurations;
  Csv csv;
  for (const StoredConfiguration& configuration : store.head().configurations) {
    configurations.push_back(Summarized(store, configuration, crashed, out, csv));
  }
  WriteFileAtomically(out / "summary.json", SweepJson(configurations));
  WriteFileAtomically(out / "trials.csv", csv.trials);
  WriteFileAtomically(out / "picks.csv", csv.attempts);
  WriteFileAtomically(out / "parts.csv", csv.parts);
  WriteFileAtomically(out / "points.csv", ConfigurationsCsv(configurations));
  WriteFileAtomically(out / "timings.csv", csv.timings);
  WriteCurve(configurations, out);
  return configurations;
}

}  // namespace pickbed::eval
