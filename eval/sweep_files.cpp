#include "eval/sweep_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "eval/results_store.h"
#include "eval/scenario_text.h"
#include "eval/series_sheet.h"
#include "scenes/files.h"

namespace pickbed {
namespace {

constexpr size_t kLongestFileName = 120;

struct Csv {
  std::string trials, picks, parts, timings;
};

// `text` with its header when it is the first.
void Append(const std::string& text, std::string& csv) {
  csv += csv.empty() ? text : text.substr(text.find('\n') + 1);
}

std::vector<std::string> PartNames(const ScenarioSpec& spec) {
  std::vector<std::string> names;
  for (const PartSpec& part : spec.objects) names.push_back(part.name);
  return names;
}

PointSummary Summarized(const ResultsStore& store, const StoredPoint& point,
                        const std::vector<CrashedTrial>& all_crashed,
                        const std::filesystem::path& out, Csv& csv) {
  const bool alone = store.head().points.size() == 1;
  const ScenarioSpec spec = ScenarioOfText(point.settings, out, (out / "results.sqlite").string());
  const std::vector<std::string> names = PartNames(spec);
  const std::vector<TrialResult> trials =
      alone ? store.ReadAll() : store.Read(point.first_trial, point.first_trial + point.trials);
  PointSummary result{point, Summarize(trials, spec.cycle, ReportedBands(spec.occlusion))};
  if (spec.occlusion.enabled) result.summary.bands = FiguresByBand(trials, spec.occlusion);
  std::vector<CrashedTrial>& crashed = result.summary.crashed;
  std::copy_if(all_crashed.begin(), all_crashed.end(), std::back_inserter(crashed),
               [&](const CrashedTrial& trial) { return trial.point == point.point; });
  std::vector<int> crashed_scenes;
  for (const CrashedTrial& trial : crashed) crashed_scenes.push_back(trial.scene);
  result.summary.stop = StopOf(trials, crashed_scenes, spec.stop_width);
  Append(TrialsCsv(trials, crashed), csv.trials);
  Append(PicksCsv(trials, names), csv.picks);
  Append(PartsCsv(trials, names), csv.parts);
  Append(TimingsCsv(trials, alone ? result.summary.cycle : CycleTime()), csv.timings);
  return result;
}

// With quotes where a cell holds a comma or quote.
std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string PointsCsv(const std::vector<PointSummary>& points) {
  std::string csv =
      "point,name,seed,first_trial,trials,finished,crashed,attempts,successes,success_rate,"
      "success_low,success_high,parts_dropped,parts_cleared,frames,top1_correct\n";
  for (const auto& [point, s] : points) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", point.point,
                       Cell(point.name), point.seed, point.first_trial, point.trials, s.trials,
                       s.crashed.size(), s.attempts, s.successes, s.success_rate,
                       s.success_ci95.low, s.success_ci95.high, s.parts_dropped, s.parts_cleared,
                       s.frames, s.top1_correct);
  }
  return csv;
}

void WriteCurve(const std::vector<PointSummary>& points, const std::filesystem::path& out) {
  std::vector<NamedCurve> curves;
  for (const auto& [point, summary] : points) {
    if (!summary.bands.empty()) curves.push_back({point.name, summary.bands});
  }
  if (curves.empty()) return;
  WriteFileAtomically(out / "curve.csv", CurveCsv(curves));
  WriteSeriesSheet(out / "pictures", curves.front().bands);
}

}  // namespace

std::string PointFileName(int point, const std::string& name) {
  std::string file = fmt::format("{:02}_{}", point, name);
  for (char& c : file) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || std::strchr("._-=,", c);
    if (!plain) c = '_';
  }
  return file.substr(0, kLongestFileName) + ".yaml";
}

std::string SweepTable(const std::vector<PointSummary>& points) {
  if (points.size() == 1 && points.front().point.name.empty()) {
    const PointSummary& run = points.front();
    return SummaryTable(run.summary);
  }
  size_t width = 5;
  for (const PointSummary& point : points) width = std::max(width, point.point.name.size());
  std::string text = fmt::format("{:<{}}  {:>11}  {:>23}  {:>9}  {:>11}\n", "Point", width, "bins",
                                 "picks that succeed", "cleared", "top-1 right");
  for (const auto& [point, s] : points) {
    const std::string rate = fmt::format("{:.1f} % [{:.1f}, {:.1f}]", 100 * s.success_rate,
                                         100 * s.success_ci95.low, 100 * s.success_ci95.high);
    text +=
        fmt::format("{:<{}}  {:>5} of {:>2}  {:>23}  {:>7.1f} %  {:>9.1f} %{}\n", point.name, width,
                    s.trials, point.trials, rate, 100 * s.cleared_rate, 100 * s.top1_precision,
                    s.crashed.empty() ? "" : fmt::format("  {} crashed", s.crashed.size()));
  }
  for (const auto& [point, summary] : points) {
    if (summary.stop) text += fmt::format("{}: {}\n", point.name, StopText(*summary.stop));
  }
  for (const auto& [point, summary] : points) {
    if (summary.bands.empty()) continue;
    text += fmt::format("\n{}\n{}", point.name, CurveTable(summary.bands));
  }
  return text;
}

std::string SweepJson(const std::vector<PointSummary>& points) {
  if (points.size() == 1 && points.front().point.name.empty()) {
    return SummaryJson(points.front().summary);
  }
  nlohmann::ordered_json json;
  json["points"] = nlohmann::ordered_json::array();
  for (const auto& [point, summary] : points) {
    nlohmann::ordered_json entry;
    entry["point"] = point.point;
    entry["name"] = point.name;
    entry.update(nlohmann::ordered_json::parse(SummaryJson(summary)));
    json["points"].push_back(std::move(entry));
  }
  return json.dump(2) + "\n";
}

std::vector<PointSummary> WriteSweepFiles(const std::filesystem::path& out) {
  const ResultsStore store = ResultsStore::OpenToRead(out);
  const std::vector<CrashedTrial> crashed = store.Crashed();
  std::vector<PointSummary> points;
  Csv csv;
  for (const StoredPoint& point : store.head().points) {
    points.push_back(Summarized(store, point, crashed, out, csv));
  }
  WriteFileAtomically(out / "summary.json", SweepJson(points));
  WriteFileAtomically(out / "trials.csv", csv.trials);
  WriteFileAtomically(out / "picks.csv", csv.picks);
  WriteFileAtomically(out / "parts.csv", csv.parts);
  WriteFileAtomically(out / "points.csv", PointsCsv(points));
  WriteFileAtomically(out / "timings.csv", csv.timings);
  WriteCurve(points, out);
  return points;
}

}  // namespace pickbed
