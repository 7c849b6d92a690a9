#include "eval/budget_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "eval/loss_budget.h"
#include "eval/report/draw_budget.h"
#include "eval/report/html_page.h"
#include "scenes/files.h"
#include "scenes/image_io.h"

namespace pickbed {
namespace {

constexpr const char* kAsRun = "as_run";

std::string Share(int count, int total) {
  return fmt::format("{} ({:.1f} %)", count, 100.0 * count / std::max(1, total));
}

std::string GainText(const Gain& gain) {
  return fmt::format("{:.1f} %  {:+.1f} [{:+.1f}, {:+.1f}]", 100 * gain.after, gain.points(),
                     100 * gain.rise.low, 100 * gain.rise.high);
}

// The first row is the header.
std::vector<std::vector<std::string>> LossCells(const BudgetRuns& runs) {
  const LossBudget attempts = BudgetOfAttempts(runs.as_run);
  const LossBudget instances = BudgetOfInstances(runs.as_run);
  std::vector<std::vector<std::string>> rows{
      {"reason", "stage", "attempts", "instances"},
      {"all", "", std::to_string(attempts.total), std::to_string(instances.total)}};
  for (const LossRow& row : LossTable()) {
    if (attempts[row.loss] + instances[row.loss] == 0) continue;
    rows.push_back({std::string(row.name), std::string(StageName(row.stage)),
                    Share(attempts[row.loss], attempts.total),
                    Share(instances[row.loss], instances.total)});
  }
  if (instances.not_asked > 0) {
    rows.push_back({"not asked for", "policy", Share(0, attempts.total),
                    Share(instances.not_asked, instances.total)});
  }
  rows.push_back({"picked", "", Share(attempts.picked, attempts.total),
                  Share(instances.picked, instances.total)});
  return rows;
}

std::vector<std::vector<std::string>> GainCells(const BudgetRuns& runs) {
  const StageGain none = GainOf(runs.as_run, runs.as_run);
  std::vector<std::vector<std::string>> rows{
      {"truth in place of", "attempts that succeed", "parts picked"},
      {"nothing", fmt::format("{:.1f} %", 100 * none.attempts.before),
       fmt::format("{:.1f} %", 100 * none.instances.before)}};
  for (const FedRun& fed : runs.fed) {
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    rows.push_back({fed.row.name, GainText(gain.attempts), GainText(gain.instances)});
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

std::string FewBinsText(const BudgetRuns& runs) {
  if (runs.as_run.size() >= static_cast<size_t>(kFewBins)) return "";
  return fmt::format("{} bins are few, and the intervals wide; {} or more tell something.",
                     runs.as_run.size(), kFewBins);
}

nlohmann::ordered_json BudgetObject(const LossBudget& budget) {
  nlohmann::ordered_json json;
  json["all"] = budget.total;
  json["picked"] = budget.picked;
  json["not_asked"] = budget.not_asked;
  json["lost"] = nlohmann::ordered_json::object();
  for (const LossRow& row : LossTable()) {
    if (row.loss != Loss::kNone) json["lost"][std::string(row.name)] = budget[row.loss];
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
  json["attempts"] = BudgetObject(BudgetOfAttempts(trials));
  json["instances"] = BudgetObject(BudgetOfInstances(trials));
  return json;
}

std::string CsvOf(const std::string& name, const std::vector<TrialResult>& trials) {
  const LossBudget attempts = BudgetOfAttempts(trials);
  const LossBudget instances = BudgetOfInstances(trials);
  std::string csv = fmt::format("{},,all,{},{}\n", name, attempts.total, instances.total);
  csv += fmt::format("{},done,picked,{},{}\n", name, attempts.picked, instances.picked);
  csv += fmt::format("{},policy,not_asked,0,{}\n", name, instances.not_asked);
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone) continue;
    csv += fmt::format("{},{},{},{},{}\n", name, StageName(row.stage), row.name, attempts[row.loss],
                       instances[row.loss]);
  }
  return csv;
}

Waterfall WaterfallOf(const LossBudget& budget, const std::string& things) {
  Waterfall waterfall{"Where picks are lost: " + things,
                      "% of all " + things,
                      "all " + things,
                      "picked",
                      budget.total,
                      {}};
  for (const LossRow& row : LossTable()) {
    if (budget[row.loss] == 0) continue;
    waterfall.steps.push_back(
        {std::string(row.name), std::string(StageName(row.stage)), budget[row.loss]});
  }
  if (budget.not_asked > 0) {
    waterfall.steps.push_back({"not asked for", "policy", budget.not_asked});
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
                  "parts picked",
                  {}};
  for (const FedRun& fed : runs.fed) {
    const StageGain gain = GainOf(runs.as_run, fed.trials);
    chart.rows.push_back({fed.row.name, DotOf(gain.attempts), DotOf(gain.instances)});
  }
  return chart;
}

std::string PageOf(const std::string& name, const BudgetRuns& runs) {
  HtmlPage page("Where picks are lost: " + name);
  page.Paragraph(fmt::format(
      "{} bins. An attempt is a look at a bin that held parts: it brings one, or is lost for one "
      "reason. An instance is a part that was dropped: it is picked, or lost for one reason, or "
      "was not asked for. The parts of both budgets sum to all.",
      runs.as_run.size()));
  page.Table(LossCells(runs));
  page.WidePicture("attempts.png", "of attempts");
  page.WidePicture("instances.png", "of parts that were dropped");
  if (runs.fed.empty()) return page.Finish();
  page.Heading("What perfecting a stage would gain");
  page.Paragraph(
      "The same bins, seeds and policy, with truth in place of a stage; in percentage points, with "
      "95 % intervals over bins, which are paired. Later looks of a bin differ once a "
      "pick does. " +
      FewBinsText(runs));
  page.Table(GainCells(runs));
  page.WidePicture("gains.png", "gain of truth in place of a stage");
  std::vector<std::vector<std::string>> rows{{"truth in place of", "which means"}};
  for (const FedRun& fed : runs.fed) rows.push_back({fed.row.name, fed.row.help});
  page.Table(rows);
  return page.Finish();
}

}  // namespace

std::string BudgetTable(const BudgetRuns& runs) {
  std::string text = fmt::format("Where picks are lost, {} bins\n{}", runs.as_run.size(),
                                 Aligned(LossCells(runs)));
  if (runs.fed.empty()) return text;
  const std::string few = FewBinsText(runs);
  return text + "What truth in place of a stage would gain, percentage points [95 % over bins]\n" +
         Aligned(GainCells(runs)) + (few.empty() ? "" : "  " + few + "\n");
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
  return json.dump(2) + "\n";
}

std::string BudgetCsv(const BudgetRuns& runs) {
  std::string csv = "truth_for,stage,reason,attempts,instances\n" + CsvOf(kAsRun, runs.as_run);
  for (const FedRun& fed : runs.fed) csv += CsvOf(fed.row.name, fed.trials);
  return csv;
}

void WriteBudget(const std::filesystem::path& folder, const std::string& name,
                 const BudgetRuns& runs) {
  std::filesystem::create_directories(folder);
  WriteFileAtomically(folder / "budget.json", BudgetJson(runs));
  WriteFileAtomically(folder / "budget.csv", BudgetCsv(runs));
  WritePng(folder / "attempts.png",
           DrawWaterfall(WaterfallOf(BudgetOfAttempts(runs.as_run), "attempts")));
  WritePng(folder / "instances.png",
           DrawWaterfall(WaterfallOf(BudgetOfInstances(runs.as_run), "instances")));
  if (!runs.fed.empty()) WritePng(folder / "gains.png", DrawGains(GainsOf(runs)));
  WriteFileAtomically(folder / "index.html", PageOf(name, runs));
}

}  // namespace pickbed
