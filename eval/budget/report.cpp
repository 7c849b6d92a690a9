#include "eval/budget/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "eval/budget/draw.h"
#include "eval/stats/statistics.h"
#include "eval/summary/failure_budget.h"
#include "eval/tolerance/report.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

constexpr const char* kAsRun = "as_run";

std::string ShareText(int count, int of) {
  return fmt::format("{} ({})", count, PercentText(count, std::max(1, of)));
}

std::string ShareText(int count, int of, const Interval& ci95) {
  return fmt::format("{} {}", ShareText(count, of), IntervalText(ci95));
}

// Header, then one line per reason. Shares are relative to what was asked for.
TableCells FailureCells(const BudgetRuns& runs) {
  const BudgetShares attempts = SharesOfAttempts(runs.as_run);
  const BudgetShares instances = SharesOfInstances(runs.as_run);
  const FailureBudget &looks = attempts.budget, &parts = instances.budget;
  TableCells rows{{"reason", "stage", "attempts", "instances"}};
  if (parts.not_asked > 0) {
    rows.push_back({"dropped", "", "", std::to_string(parts.total)});
    rows.push_back({"not asked for", "policy", "", std::to_string(parts.not_asked)});
  }
  rows.push_back({"asked for", "", std::to_string(looks.asked()), std::to_string(parts.asked())});
  for (const FailureRow& row : FailureTable()) {
    const int of_looks = looks[row.failure], of_parts = parts[row.failure];
    if (of_looks + of_parts == 0) continue;
    rows.push_back({std::string(row.name), std::string(StageName(row.stage)),
                    ShareText(of_looks, looks.asked(), attempts[row.failure]),
                    ShareText(of_parts, parts.asked(), instances[row.failure])});
  }
  rows.push_back({"picked", "", ShareText(looks.picked, looks.asked(), attempts.picked),
                  ShareText(parts.picked, parts.asked(), instances.picked)});
  return rows;
}

TableCells GainCells(const BudgetRuns& runs) {
  const StageGain none = GainOf(runs.as_run, runs.as_run);
  TableCells rows{
      {"truth in place of", "attempts that succeed", "gain", "instances picked", "gain"},
      {"nothing", PercentText(none.attempts.before), "", PercentText(none.instances.before), ""}};
  for (const OracleRerun& fed : runs.fed) {
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    rows.push_back({fed.row.name, PercentText(gain.attempts.after), GainText(gain.attempts),
                    PercentText(gain.instances.after), GainText(gain.instances)});
  }
  return rows;
}

std::string Aligned(const TableCells& rows) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = " ";
    for (size_t i = 0; i < row.size(); ++i) line += fmt::format(" {:<{}} ", row[i], widths[i]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

nlohmann::ordered_json BudgetObject(const BudgetShares& shares) {
  const FailureBudget& budget = shares.budget;
  nlohmann::ordered_json json;
  json["all"] = budget.total;
  json["not_asked"] = budget.not_asked;
  json["asked"] = budget.asked();
  json["picked"] = budget.picked;
  json["picked_ci95"] = {shares.picked.low, shares.picked.high};
  json["failures"] = nlohmann::ordered_json::object();
  json["failures_ci95"] = nlohmann::ordered_json::object();
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone) continue;
    const Interval& ci95 = shares[row.failure];
    json["failures"][std::string(row.name)] = budget[row.failure];
    json["failures_ci95"][std::string(row.name)] = {ci95.low, ci95.high};
  }
  return json;
}

nlohmann::ordered_json GainObject(const Gain& gain) {
  nlohmann::ordered_json json;
  json["before"] = gain.before;
  json["after"] = gain.after;
  json["gain"] = gain.after - gain.before;
  json["gain_ci95"] = {gain.rise.low, gain.rise.high};
  return json;
}

nlohmann::ordered_json RowObject(const std::string& name, const std::vector<TrialResult>& trials) {
  nlohmann::ordered_json json;
  json["name"] = name;
  json["attempts"] = BudgetObject(SharesOfAttempts(trials));
  json["instances"] = BudgetObject(SharesOfInstances(trials));
  return json;
}

std::string CsvOf(const std::string& name, const std::vector<TrialResult>& trials) {
  const BudgetShares attempts = SharesOfAttempts(trials), instances = SharesOfInstances(trials);
  const FailureBudget &looks = attempts.budget, &parts = instances.budget;
  const auto intervals = [](const Interval& of_looks, const Interval& of_parts) {
    return fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}", of_looks.low, of_looks.high, of_parts.low,
                       of_parts.high);
  };
  std::string csv = fmt::format("{},,all,{},{},,,,\n", name, looks.total, parts.total);
  csv += fmt::format("{},done,picked,{},{},{}\n", name, looks.picked, parts.picked,
                     intervals(attempts.picked, instances.picked));
  csv += fmt::format("{},policy,not_asked,0,{},,,,\n", name, parts.not_asked);
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone) continue;
    csv +=
        fmt::format("{},{},{},{},{},{}\n", name, StageName(row.stage), row.name, looks[row.failure],
                    parts[row.failure], intervals(attempts[row.failure], instances[row.failure]));
  }
  return csv;
}

Waterfall WaterfallOf(const BudgetShares& shares, const std::string& things) {
  const FailureBudget& budget = shares.budget;
  const bool some = budget.not_asked > 0;
  Waterfall waterfall{"Where picks are lost: " + things + (some ? " asked for" : ""),
                      some ? "those asked for" : "all " + things,
                      some ? "asked for" : "all " + things,
                      {"picked", "", budget.picked, shares.picked},
                      budget.asked(),
                      {}};
  for (const FailureRow& row : FailureTable()) {
    if (budget[row.failure] == 0) continue;
    waterfall.steps.push_back({std::string(row.name), std::string(StageName(row.stage)),
                               budget[row.failure], shares[row.failure]});
  }
  return waterfall;
}

Waterfall AttemptsWaterfall(const BudgetRuns& runs) {
  return WaterfallOf(SharesOfAttempts(runs.as_run), "attempts");
}

Waterfall InstancesWaterfall(const BudgetRuns& runs) {
  return WaterfallOf(SharesOfInstances(runs.as_run), "instances");
}

GainRows GainsOf(const BudgetRuns& runs) {
  GainRows gains{"What truth in place of a stage would gain",
                 "attempts that succeed",
                 "instances picked, of those asked for",
                 {}};
  for (const OracleRerun& fed : runs.fed) {
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    gains.rows.push_back({fed.row.name, gain.attempts, gain.instances});
  }
  return gains;
}

std::string AskedText(const BudgetRuns& runs) {
  const FailureBudget parts = BudgetOfInstances(runs.as_run);
  if (parts.not_asked == 0) return "Shares are of all.";
  return fmt::format(
      "The policy limits the looks at a bin: of {} parts that were dropped, {} were asked for, one "
      "by each look (and those that a pick cost the bin by the way). Shares, intervals and gains "
      "are of these.",
      parts.total, parts.asked());
}

void AddGains(const BudgetRuns& runs, HtmlPage& page) {
  page.Heading("What perfecting a stage would gain");
  page.Paragraph(
      "The same bins, seeds and policy, with truth in place of a stage; in percentage points, with "
      "95 % intervals over bins, which are paired. Later looks of a bin differ once a pick does.");
  page.Table(GainCells(runs));
  page.Chart(GainsChart("gains", GainsOf(runs)));
  TableCells rows{{"truth in place of", "which means"}};
  for (const OracleRerun& fed : runs.fed) rows.push_back({fed.row.name, fed.row.help});
  page.Table(rows);
}

void AddForecasts(const BudgetRuns& runs, HtmlPage& page) {
  page.Heading("What pose errors foretell");
  page.Paragraph(
      "Picks whose pose stood on a part of its kind; of the others no error is known. AUC is the "
      "chance that a score puts a pick that succeeded before one that failed (0.5 is guessing), "
      "with 95 % intervals over bins.");
  for (const PickForecast& f : runs.forecasts) {
    page.Paragraph(fmt::format(
        "{}: {} of {} picks succeeded; by its pose errors, each on the part alone, the "
        "tolerance map foretells {:.1f}, knowing the grasps {:.1f}. {}",
        f.part, f.successes, f.picks, f.expected, f.expected_with_grasp, FewBinsText(f.bins)));
    page.Table(PredictorCells(f.predictors));
  }
}

HtmlPage PageOf(const std::string& name, const BudgetRuns& runs) {
  HtmlPage page("Where picks are lost: " + name);
  page.Paragraph(fmt::format(
      "{} bins. An attempt is a look at a bin that held parts: it brings one, or is lost for one "
      "reason. An instance is a part that was dropped: it is picked, or lost for one reason, or "
      "was not asked for. The parts of both budgets sum to all. {} Brackets are 95 % intervals "
      "over "
      "bins. {}",
      runs.as_run.size(), AskedText(runs), FewBinsText(static_cast<int>(runs.as_run.size()))));
  page.Table(FailureCells(runs));
  page.Chart(WaterfallChart("attempts", AttemptsWaterfall(runs)));
  page.Chart(WaterfallChart("instances", InstancesWaterfall(runs)));
  if (!runs.fed.empty()) AddGains(runs, page);
  if (!runs.forecasts.empty()) AddForecasts(runs, page);
  return page;
}

}  // namespace

std::string BudgetTable(const BudgetRuns& runs) {
  std::string text = fmt::format("Where picks are lost, {} bins [95 % over bins]\n{}",
                                 runs.as_run.size(), Aligned(FailureCells(runs)));
  if (!runs.fed.empty()) {
    text += "What truth in place of a stage would gain, percentage points [95 % over bins]\n" +
            Aligned(GainCells(runs));
  }
  const std::string few = FewBinsText(static_cast<int>(runs.as_run.size()));
  if (!few.empty()) text += "  " + few + "\n";
  return text + ForecastText(runs.forecasts);
}

std::string BudgetJson(const BudgetRuns& runs) {
  nlohmann::ordered_json json;
  json["trials"] = runs.as_run.size();
  json["rows"] = nlohmann::ordered_json::array();
  json["rows"].push_back(RowObject(kAsRun, runs.as_run));
  for (const OracleRerun& fed : runs.fed) {
    nlohmann::ordered_json row = RowObject(fed.row.name, fed.trials);
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    row["success"] = GainObject(gain.attempts);
    row["cleared"] = GainObject(gain.instances);
    json["rows"].push_back(std::move(row));
  }
  if (!runs.forecasts.empty()) {
    json["pick_forecasts"] = nlohmann::ordered_json::parse(ForecastJson(runs.forecasts));
  }
  return json.dump(2) + "\n";
}

std::string BudgetCsv(const BudgetRuns& runs) {
  std::string csv =
      "truth_for,stage,reason,attempts,instances,attempts_low,attempts_high,instances_low,"
      "instances_high\n" +
      CsvOf(kAsRun, runs.as_run);
  for (const OracleRerun& fed : runs.fed) csv += CsvOf(fed.row.name, fed.trials);
  return csv;
}

std::string WriteBudget(const std::filesystem::path& folder, const std::string& name,
                        const BudgetRuns& runs) {
  std::filesystem::create_directories(folder);
  WriteFileAtomically(folder / "budget.json", BudgetJson(runs));
  WriteFileAtomically(folder / "budget.csv", BudgetCsv(runs));
  WritePng(folder / "attempts.png", DrawWaterfall(AttemptsWaterfall(runs)));
  WritePng(folder / "instances.png", DrawWaterfall(InstancesWaterfall(runs)));
  if (!runs.fed.empty()) WritePng(folder / "gains.png", DrawGains(GainsOf(runs)));
  return WritePage(folder / "index.html", PageOf(name, runs));
}

}  // namespace pickbed::eval
