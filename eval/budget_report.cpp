#include "eval/budget_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "eval/few_bins.h"
#include "eval/loss_budget.h"
#include "eval/report/draw_budget.h"
#include "eval/report/html_page.h"
#include "eval/tolerance_report.h"
#include "scenes/files.h"
#include "scenes/image_io.h"

namespace pickbed {
namespace {

constexpr const char* kAsRun = "as_run";

std::string ShareText(int count, int of) {
  return fmt::format("{} ({:.1f} %)", count, 100.0 * count / std::max(1, of));
}

std::string ShareText(int count, int of, const Interval& ci95) {
  return fmt::format("{} [{:.1f}, {:.1f}]", ShareText(count, of), 100 * ci95.low, 100 * ci95.high);
}

std::string RateText(double rate) { return fmt::format("{:.1f} %", 100 * rate); }

std::string GainText(const Gain& gain) {
  return fmt::format("{:+.1f} [{:+.1f}, {:+.1f}]", gain.points(), 100 * gain.rise.low,
                     100 * gain.rise.high);
}

// The first row is the header. Shares are of what was asked for.
std::vector<std::vector<std::string>> LossCells(const BudgetRuns& runs) {
  const BudgetShares attempts = SharesOfAttempts(runs.as_run);
  const BudgetShares instances = SharesOfInstances(runs.as_run);
  const LossBudget &looks = attempts.budget, &parts = instances.budget;
  std::vector<std::vector<std::string>> rows{{"reason", "stage", "attempts", "instances"}};
  if (parts.not_asked > 0) {
    rows.push_back({"dropped", "", "", std::to_string(parts.total)});
    rows.push_back({"not asked for", "policy", "", std::to_string(parts.not_asked)});
  }
  rows.push_back({"asked for", "", std::to_string(looks.asked()), std::to_string(parts.asked())});
  for (const LossRow& row : LossTable()) {
    const int of_looks = looks[row.loss], of_parts = parts[row.loss];
    if (of_looks + of_parts == 0) continue;
    rows.push_back({std::string(row.name), std::string(StageName(row.stage)),
                    ShareText(of_looks, looks.asked(), attempts[row.loss]),
                    ShareText(of_parts, parts.asked(), instances[row.loss])});
  }
  rows.push_back({"picked", "", ShareText(looks.picked, looks.asked(), attempts.picked),
                  ShareText(parts.picked, parts.asked(), instances.picked)});
  return rows;
}

std::vector<std::vector<std::string>> GainCells(const BudgetRuns& runs) {
  const StageGain none = GainOf(runs.as_run, runs.as_run);
  std::vector<std::vector<std::string>> rows{
      {"truth in place of", "attempts that succeed", "gain", "instances picked", "gain"},
      {"nothing", RateText(none.attempts.before), "", RateText(none.instances.before), ""}};
  for (const FedRun& fed : runs.fed) {
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    rows.push_back({fed.row.name, RateText(gain.attempts.after), GainText(gain.attempts),
                    RateText(gain.instances.after), GainText(gain.instances)});
  }
  return rows;
}

std::string Aligned(const std::vector<std::vector<std::string>>& rows) {
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
  const LossBudget& budget = shares.budget;
  nlohmann::ordered_json json;
  json["all"] = budget.total;
  json["not_asked"] = budget.not_asked;
  json["asked"] = budget.asked();
  json["picked"] = budget.picked;
  json["picked_ci95"] = {shares.picked.low, shares.picked.high};
  json["lost"] = nlohmann::ordered_json::object();
  json["lost_ci95"] = nlohmann::ordered_json::object();
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone) continue;
    const Interval& ci95 = shares[row.loss];
    json["lost"][std::string(row.name)] = budget[row.loss];
    json["lost_ci95"][std::string(row.name)] = {ci95.low, ci95.high};
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
  const LossBudget &looks = attempts.budget, &parts = instances.budget;
  const auto intervals = [](const Interval& of_looks, const Interval& of_parts) {
    return fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}", of_looks.low, of_looks.high, of_parts.low,
                       of_parts.high);
  };
  std::string csv = fmt::format("{},,all,{},{},,,,\n", name, looks.total, parts.total);
  csv += fmt::format("{},done,picked,{},{},{}\n", name, looks.picked, parts.picked,
                     intervals(attempts.picked, instances.picked));
  csv += fmt::format("{},policy,not_asked,0,{},,,,\n", name, parts.not_asked);
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone) continue;
    csv += fmt::format("{},{},{},{},{},{}\n", name, StageName(row.stage), row.name, looks[row.loss],
                       parts[row.loss], intervals(attempts[row.loss], instances[row.loss]));
  }
  return csv;
}

Waterfall WaterfallOf(const BudgetShares& shares, const std::string& things) {
  const LossBudget& budget = shares.budget;
  const bool some = budget.not_asked > 0;
  Waterfall waterfall{
      "Where picks are lost: " + things + (some ? " asked for" : ""),
      fmt::format("% of {}; brackets: 95 % over bins", some ? "those asked for" : "all " + things),
      some ? "asked for" : "all " + things,
      {"picked", "", budget.picked, 100 * shares.picked.low, 100 * shares.picked.high},
      budget.asked(),
      {}};
  for (const LossRow& row : LossTable()) {
    if (budget[row.loss] == 0) continue;
    const Interval& ci95 = shares[row.loss];
    waterfall.steps.push_back({std::string(row.name), std::string(StageName(row.stage)),
                               budget[row.loss], 100 * ci95.low, 100 * ci95.high});
  }
  return waterfall;
}

GainDot DotOf(const Gain& gain) {
  return {gain.points(), 100 * gain.rise.low, 100 * gain.rise.high};
}

GainChart GainsOf(const BudgetRuns& runs) {
  GainChart chart{"What truth in place of a stage would gain",
                  "gain, percentage points (bars: 95 % over bins)",
                  "attempts that succeed",
                  "instances picked, of those asked for",
                  {}};
  for (const FedRun& fed : runs.fed) {
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    chart.rows.push_back({fed.row.name, DotOf(gain.attempts), DotOf(gain.instances)});
  }
  return chart;
}

std::string AskedText(const BudgetRuns& runs) {
  const LossBudget parts = BudgetOfInstances(runs.as_run);
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
  page.WidePicture("gains.png", "gain of truth in place of a stage, with 95 % intervals");
  std::vector<std::vector<std::string>> rows{{"truth in place of", "which means"}};
  for (const FedRun& fed : runs.fed) rows.push_back({fed.row.name, fed.row.help});
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

std::string PageOf(const std::string& name, const BudgetRuns& runs) {
  HtmlPage page("Where picks are lost: " + name);
  page.Paragraph(fmt::format(
      "{} bins. An attempt is a look at a bin that held parts: it brings one, or is lost for one "
      "reason. An instance is a part that was dropped: it is picked, or lost for one reason, or "
      "was not asked for. The parts of both budgets sum to all. {} Brackets are 95 % intervals "
      "over "
      "bins. {}",
      runs.as_run.size(), AskedText(runs), FewBinsText(static_cast<int>(runs.as_run.size()))));
  page.Table(LossCells(runs));
  page.WidePicture("attempts.png", "attempts: from all down to those that brought a part");
  page.WidePicture("instances.png", "parts: from those asked for down to those picked");
  if (!runs.fed.empty()) AddGains(runs, page);
  if (!runs.forecasts.empty()) AddForecasts(runs, page);
  return page.Finish();
}

}  // namespace

std::string BudgetTable(const BudgetRuns& runs) {
  std::string text = fmt::format("Where picks are lost, {} bins [95 % over bins]\n{}",
                                 runs.as_run.size(), Aligned(LossCells(runs)));
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
  for (const FedRun& fed : runs.fed) {
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
  for (const FedRun& fed : runs.fed) csv += CsvOf(fed.row.name, fed.trials);
  return csv;
}

void WriteBudget(const std::filesystem::path& folder, const std::string& name,
                 const BudgetRuns& runs) {
  std::filesystem::create_directories(folder);
  WriteFileAtomically(folder / "budget.json", BudgetJson(runs));
  WriteFileAtomically(folder / "budget.csv", BudgetCsv(runs));
  WritePng(folder / "attempts.png",
           DrawWaterfall(WaterfallOf(SharesOfAttempts(runs.as_run), "attempts")));
  WritePng(folder / "instances.png",
           DrawWaterfall(WaterfallOf(SharesOfInstances(runs.as_run), "instances")));
  if (!runs.fed.empty()) WritePng(folder / "gains.png", DrawGains(GainsOf(runs)));
  WriteFileAtomically(folder / "index.html", PageOf(name, runs));
}

}  // namespace pickbed
