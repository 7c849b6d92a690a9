#include "eval/summary/result_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "eval/store/results_store.h"
#include "eval/store/store_check.h"
#include "eval/summary/occlusion_sheet.h"
#include "eval/summary/run_columns.h"
#include "eval/summary/run_csv.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/image/image_io.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

constexpr size_t kLongestFileName = 120;

struct Csv {
  std::string trials, attempts, instances, instance_outcomes, timings;
};

// Appends a CSV table. Only the first table keeps its header line.
void Append(const std::string& text, std::string& csv) {
  csv += csv.empty() ? text : text.substr(text.find('\n') + 1);
}

std::vector<std::string> ObjectNames(const ScenarioSpec& spec) {
  std::vector<std::string> names;
  for (const ObjectSpec& object : spec.objects) names.push_back(object.name);
  return names;
}

ConfigurationSummary Summarized(const ResultsStore& store, const StoredConfiguration& configuration,
                                const std::vector<CrashedTrial>& all_crashed,
                                const std::filesystem::path& out, Csv& csv) {
  const bool single = store.head().configurations.size() == 1;
  const ScenarioSpec spec =
      ScenarioOfText(configuration.settings, out, (out / kStoreFile).string());
  const std::vector<std::string> names = ObjectNames(spec);
  const std::vector<TrialResult> trials =
      single
          ? store.ReadAll()
          : store.Read(configuration.first_trial, configuration.first_trial + configuration.trials);
  for (const TrialResult& trial : trials) {
    CheckTrial(trial, {names.size(), spec.occlusion.bands.size()}, (out / kStoreFile).string());
  }
  ConfigurationSummary result{configuration,
                              Summarize(trials, spec.cycle, ReportedBands(spec.occlusion))};
  if (spec.occlusion.enabled) {
    result.summary.bands = StatisticsByBand(trials, spec.occlusion);
    result.summary.hidden = StatisticsByHiddenShare(trials);
  }
  std::vector<CrashedTrial>& crashed = result.summary.crashed;
  std::copy_if(
      all_crashed.begin(), all_crashed.end(), std::back_inserter(crashed),
      [&](const CrashedTrial& trial) { return trial.configuration == configuration.number; });
  std::vector<BinIndex> crashed_bins;
  for (const CrashedTrial& trial : crashed) crashed_bins.push_back(trial.bin_index);
  result.summary.stop = StopOf(trials, crashed_bins, spec.stop_width);
  Append(TrialsCsv(trials, crashed), csv.trials);
  Append(AttemptsCsv(trials, names), csv.attempts);
  Append(InstancesCsv(trials, names), csv.instances);
  Append(InstanceOutcomesCsv(trials, names), csv.instance_outcomes);
  Append(TimingsCsv(trials, single ? result.summary.cycle : CycleTime()), csv.timings);
  return result;
}

std::string ConfigurationsCsv(const std::vector<ConfigurationSummary>& configurations) {
  std::string csv = HeaderLine(ConfigurationsColumns());
  for (const auto& [configuration, s] : configurations) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", configuration.number,
                       CsvCell(configuration.name), configuration.seed, configuration.first_trial,
                       configuration.trials, s.trials, s.crashed.size(), s.executed_grasps,
                       s.successes, s.success_rate, IntervalCells(s.success_ci95),
                       s.instances_dropped, s.instances_cleared, s.frames, s.top1_correct);
  }
  return csv;
}

void WriteCurve(const std::vector<ConfigurationSummary>& configurations,
                const std::filesystem::path& out) {
  std::vector<NamedCurve> curves;
  std::vector<NamedHiddenCurve> hidden;
  for (const auto& [configuration, summary] : configurations) {
    if (summary.bands.empty()) continue;
    curves.push_back({configuration.name, summary.bands});
    hidden.push_back({configuration.name, summary.hidden});
  }
  if (curves.empty()) return;
  WriteFileAtomically(out / kCurveFile, CurveCsv(curves));
  WriteFileAtomically(out / kHiddenShareFile, HiddenShareCsv(hidden));
  MakeFolder(out / kPicturesFolder);
  WritePng(out / kPicturesFolder / kHiddenShareSheet, DrawHiddenShare(hidden));
  WriteSeriesSheet(out / kPicturesFolder / kOcclusionSheet, curves.front().bands);
}

// Names of an earlier version.
constexpr const char* kFormerTables[] = {"picks.csv", "parts.csv", "points.csv"};
constexpr char kFormerConfigurationsFolder[] = "points";
constexpr std::pair<std::string_view, std::string_view> kFormerPictureWords[] = {
    {"attempt_", "pick_"}, {"_failed", "_lost"}};

// Other people can have named the configurations.
std::string NameShown(const StoredConfiguration& configuration) {
  return Printable(configuration.name);
}

}  // namespace

std::filesystem::path PicturesOf(const std::filesystem::path& out, int trial) {
  return out / kPicturesFolder / fmt::format("trial_{:04}", trial);
}

std::string AttemptPicture(int attempt, std::string_view what) {
  return fmt::format("attempt_{:02}_{}.png", attempt, what);
}

std::string FailurePicture(int attempt) { return fmt::format("attempt_{:02}_failed.jpg", attempt); }

std::filesystem::path FindPicture(const std::filesystem::path& folder, const std::string& name) {
  std::string former = name;
  for (const auto& [now, was] : kFormerPictureWords) {
    if (const size_t at = former.find(now); at != std::string::npos) {
      former.replace(at, now.size(), was);
    }
  }
  for (const std::string& file : {name, former}) {
    if (std::filesystem::is_regular_file(folder / file)) return folder / file;
  }
  return {};
}

std::filesystem::path MakeConfigurationsFolder(const std::filesystem::path& out) {
  const std::filesystem::path former = out / kFormerConfigurationsFolder;
  std::error_code error;  // another shard may do the same at the same time
  for (const auto& entry : std::filesystem::directory_iterator(former, error)) {
    if (entry.path().extension() == ".yaml") std::filesystem::remove(entry.path(), error);
  }
  std::filesystem::remove(former, error);  // only if it is empty
  std::filesystem::create_directories(out / kConfigurationsFolder);
  return out / kConfigurationsFolder;
}

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
  size_t width = 13;
  for (const ConfigurationSummary& configuration : configurations)
    width = std::max(width, NameShown(configuration.configuration).size());
  std::string text = fmt::format("{:<{}}  {:>11}  {:>23}  {:>9}  {:>11}\n", "Configuration", width,
                                 "bins", "picks that succeed", "cleared", "top-1 right");
  bool too_few = false;  // an interval is missing
  for (const auto& [configuration, s] : configurations) {
    const std::string rate = ShortRateText({s.successes, s.executed_grasps, s.success_ci95});
    too_few = too_few || !s.success_ci95.is_known();
    text += fmt::format("{:<{}}  {:>5} of {:>2}  {:>23}  {:>9}  {:>11}{}\n",
                        NameShown(configuration), width, s.trials, configuration.trials, rate,
                        PercentText(s.requested_picked.hits, s.requested_picked.samples),
                        PercentText(s.top1_precision),
                        s.crashed.empty() ? "" : fmt::format("  {} crashed", s.crashed.size()));
  }
  for (const auto& [configuration, summary] : configurations) {
    if (summary.stop)
      text += fmt::format("{}: {}\n", NameShown(configuration), StopText(*summary.stop));
  }
  for (const auto& [configuration, summary] : configurations) {
    if (summary.bands.empty()) continue;
    text += fmt::format("\n{}\n{}", NameShown(configuration),
                        CurveTable(summary.bands, summary.trials < kMinBinsOfInterval));
  }
  if (too_few) text += fmt::format("no interval: {}, use {} or more\n", kTooFewBins, kFewBins);
  return text;
}

std::string SweepJson(const std::vector<ConfigurationSummary>& configurations) {
  if (configurations.size() == 1 && configurations.front().configuration.name.empty()) {
    return SummaryJson(configurations.front().summary);
  }
  nlohmann::ordered_json json;
  json["configurations"] = nlohmann::ordered_json::array();
  for (const auto& [configuration, summary] : configurations) {
    nlohmann::ordered_json entry;
    entry["configuration"] = configuration.number;
    entry["name"] = configuration.name;
    entry.update(nlohmann::ordered_json::parse(SummaryJson(summary)));
    json["configurations"].push_back(std::move(entry));
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
  for (const char* table : kFormerTables) std::filesystem::remove(out / table);
  WriteFileAtomically(out / kSummaryFile, SweepJson(configurations));
  WriteFileAtomically(out / kTrialsFile, csv.trials);
  WriteFileAtomically(out / kAttemptsFile, csv.attempts);
  WriteFileAtomically(out / kInstancesFile, csv.instances);
  WriteFileAtomically(out / kInstanceOutcomesFile, csv.instance_outcomes);
  WriteFileAtomically(out / kConfigurationsFile, ConfigurationsCsv(configurations));
  WriteFileAtomically(out / kTimingsFile, csv.timings);
  WriteCurve(configurations, out);
  return configurations;
}

}  // namespace pickbed::eval
