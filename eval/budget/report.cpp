#include "eval/budget/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "eval/budget/draw.h"
#include "eval/metrics/interval_json.h"
#include "eval/stats/statistics.h"
#include "eval/summary/failure_budget.h"
#include "eval/tolerance/report.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

constexpr const char* kAsRun = "as_run";

std::string ShareText(int count, int of) {
  return fmt::format("{} ({})", count, PercentText(count, std::max(1, of)));
}

std::string ShareText(int count, int of, const Interval& ci95) {
  return ci95.is_known() ? fmt::format("{} {}", ShareText(count, of), IntervalText(ci95))
                         : ShareText(count, of);
}

// Header, then one line per reason. Shares are relative to what was asked for.
TableCells FailureCells(const BudgetRuns& runs) {
  const BudgetShares attempts = SharesOfAttempts(runs.as_run);
  const BudgetShares instances = SharesOfInstances(runs.as_run);
  const FailureBudget &attempt_budget = attempts.budget, &instance_budget = instances.budget;
  TableCells rows{{"reason", "stage", "attempts", "instances"}};
  if (instance_budget.not_asked > 0) {
    rows.push_back({"dropped", "", "", std::to_string(instance_budget.total)});
    rows.push_back({"not requested", "policy", "", std::to_string(instance_budget.not_asked)});
  }
  rows.push_back({"requested", "", std::to_string(attempt_budget.asked()),
                  std::to_string(instance_budget.asked())});
  for (const FailureRow& row : FailureTable()) {
    const int of_attempts = attempt_budget[row.failure],
              of_instances = instance_budget[row.failure];
    if (of_attempts + of_instances == 0) continue;
    rows.push_back({std::string(row.name), std::string(StageName(row.stage)),
                    ShareText(of_attempts, attempt_budget.asked(), attempts[row.failure]),
                    ShareText(of_instances, instance_budget.asked(), instances[row.failure])});
  }
  rows.push_back({"picked", "",
                  ShareText(attempt_budget.picked, attempt_budget.asked(), attempts.picked),
                  ShareText(instance_budget.picked, instance_budget.asked(), instances.picked)});
  return rows;
}

TableCells GainCells(const BudgetRuns& runs) {
  const StageGain none = GainOf(runs.as_run, runs.as_run);
  TableCells rows{
      {"ground truth for", "successful attempts", "gain", "instances picked", "gain"},
      {"nothing", PercentText(none.attempts.before), "", PercentText(none.instances.before), ""}};
  for (const OracleRerun& rerun : runs.reruns) {
    const StageGain gain = GainOf(runs.as_run, rerun.trials);
    rows.push_back({rerun.row.name, PercentText(gain.attempts.after), GainText(gain.attempts),
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
  AddInterval(json, "picked_ci95", shares.picked);
  json["failures"] = nlohmann::ordered_json::object();
  auto& intervals = json["failures_ci95"] = nlohmann::ordered_json::object();
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone) continue;
    json["failures"][std::string(row.name)] = budget[row.failure];
    AddInterval(intervals, std::string(row.name), shares[row.failure]);
  }
  return json;
}

nlohmann::ordered_json GainObject(const Gain& gain) {
  nlohmann::ordered_json json;
  json["before"] = gain.before;
  json["after"] = gain.after;
  json["gain"] = gain.after - gain.before;
  AddInterval(json, "gain_ci95", gain.rise);
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
  const FailureBudget &attempt_budget = attempts.budget, &instance_budget = instances.budget;
  const auto intervals = [](const Interval& of_attempts, const Interval& of_instances) {
    constexpr int kDecimals = 4;
    return fmt::format("{},{}", IntervalCells(of_attempts, kDecimals),
                       IntervalCells(of_instances, kDecimals));
  };
  std::string csv =
      fmt::format("{},,all,{},{},,,,\n", name, attempt_budget.total, instance_budget.total);
  csv += fmt::format("{},done,picked,{},{},{}\n", name, attempt_budget.picked,
                     instance_budget.picked, intervals(attempts.picked, instances.picked));
  csv += fmt::format("{},policy,not_asked,0,{},,,,\n", name, instance_budget.not_asked);
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone) continue;
    csv += fmt::format("{},{},{},{},{},{}\n", name, StageName(row.stage), row.name,
                       attempt_budget[row.failure], instance_budget[row.failure],
                       intervals(attempts[row.failure], instances[row.failure]));
  }
  return csv;
}

Waterfall WaterfallOf(const BudgetShares& shares, const std::string& things) {
  const FailureBudget& budget = shares.budget;
  const bool some = budget.not_asked > 0;
  Waterfall waterfall{"Failed picks by reason: " + things + (some ? " requested" : ""),
                      (some ? "requested " : "all ") + things,
                      some ? "requested" : "all " + things,
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
  GainRows gains{"Gain if a stage is replaced by ground truth",
                 "successful attempts",
                 "picked instances, among the requested ones",
                 {}};
  for (const OracleRerun& rerun : runs.reruns) {
    const StageGain gain = GainOf(runs.as_run, rerun.trials);
    gains.rows.push_back({rerun.row.name, gain.attempts, gain.instances});
  }
  return gains;
}

std::string AskedText(const BudgetRuns& runs) {
  const FailureBudget instance_budget = BudgetOfInstances(runs.as_run);
  if (instance_budget.not_asked == 0) return "Shares are of all.";
  return fmt::format(
      "The policy limits the attempts per bin: of {} dropped instances, {} were requested, one by "
      "each attempt (plus instances that an attempt removed by accident). Shares, intervals "
      "and gains refer to the requested ones.",
      instance_budget.total, instance_budget.asked());
}

// Says what the shares are of, and how they differ from the success rate of `pickbed run`.
std::string AttemptsText(const BudgetRuns& runs) {
  const FailureBudget budget = BudgetOfAttempts(runs.as_run);
  const Cluster executed = SumOf(CountByScene(runs.as_run, SuccessOfAttempts()));
  std::string text = fmt::format(
      "An attempt is one image and the pick that follows, also if no grasp is executed. `run` "
      "gives its success rate over the executed grasps: {} of {}; here it is {} of {} attempts.",
      executed.hits, executed.samples, budget.picked, budget.asked());
  if (budget.Of(Stage::kApproach) > 0) {
    text +=
        " Failures of the stage approach include collisions that a pose error caused; the gain "
        "with ground truth for the pose shows how many.";
  }
  return text;
}

void AddGains(const BudgetRuns& runs, HtmlPage& page) {
  page.Heading("Gain if a stage is replaced by ground truth");
  page.Paragraph(
      "The same bins, seeds and policy, with ground truth in place of a stage. Gains are in "
      "percentage points, with paired 95 % intervals over bins. Later attempts in a bin differ as "
      "soon as one pick differs.");
  page.Table(GainCells(runs));
  page.Chart(GainsChart("gains", GainsOf(runs)));
  TableCells rows{{"ground truth for", "meaning"}};
  for (const OracleRerun& rerun : runs.reruns) rows.push_back({rerun.row.name, rerun.row.help});
  page.Table(rows);
}

void AddForecasts(const BudgetRuns& runs, HtmlPage& page) {
  page.Heading("Prediction of picks from pose errors");
  page.Paragraph(
      "Only picks at a pose that matches an instance of its object; the error of other poses is "
      "unknown. AUC is the probability that a score ranks a successful pick above a failed one "
      "(0.5 is chance), with 95 % intervals over bins.");
  for (const PickForecast& f : runs.forecasts) {
    page.Paragraph(fmt::format(
        "{}: {} of {} picks succeeded; the tolerance map predicts {:.1f} from the pose errors of "
        "single objects, and {:.1f} if the grasps are known. {}",
        f.object, f.successes, f.picks, f.expected, f.expected_with_grasp, FewBinsText(f.bins)));
    page.Table(PredictorCells(f.predictors));
  }
}

HtmlPage PageOf(const std::string& name, const BudgetRuns& runs) {
  HtmlPage page("Failed picks by reason: " + name);
  page.Paragraph(fmt::format(
      "{} bins. An attempt is one image of a bin with instances in it: it picks an instance, or "
      "fails for one reason. An instance is one dropped object: it is picked, or fails for one "
      "reason, or was not requested. Each budget sums to its total. {} Brackets are 95 % intervals "
      "over bins. {} {}",
      runs.as_run.size(), AskedText(runs), AttemptsText(runs),
      FewBinsText(static_cast<int>(runs.as_run.size()))));
  page.Table(FailureCells(runs));
  page.Chart(WaterfallChart("attempts", AttemptsWaterfall(runs)));
  page.Chart(WaterfallChart("instances", InstancesWaterfall(runs)));
  if (!runs.reruns.empty()) AddGains(runs, page);
  if (!runs.forecasts.empty()) AddForecasts(runs, page);
  return page;
}

}  // namespace

std::string BudgetTable(const BudgetRuns& runs) {
  std::string text =
      fmt::format("Failed picks by reason, {} bins [95 % over bins]\n{}  {}\n", runs.as_run.size(),
                  Aligned(FailureCells(runs)), AttemptsText(runs));
  if (!runs.reruns.empty()) {
    text += "Gain if a stage is replaced by ground truth, percentage points [95 % over bins]\n" +
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
  for (const OracleRerun& rerun : runs.reruns) {
    nlohmann::ordered_json row = RowObject(rerun.row.name, rerun.trials);
    const StageGain gain = GainOf(runs.as_run, rerun.trials);
    row["success"] = GainObject(gain.attempts);
    row["cleared"] = GainObject(gain.instances);
    json["rows"].push_back(std::move(row));
  }
  if (!runs.forecasts.empty()) {
    json["pick_forecasts"] = nlohmann::ordered_json::parse(ForecastJson(runs.forecasts));
  }
  return json.dump(2) + "\n";
}

ResultColumns BudgetKeys() {
  ResultColumns keys{
      {"trials", "number of bins"},
      {"rows[].name", "as_run, or the stage that ground truth replaced"},
  };
  for (const std::string group : {"attempts", "instances"}) {
    const std::string at = "rows[]." + group + ".";
    AddColumns({{at + "all", "number of " + group},
                {at + "not_asked", "number that was not requested"},
                {at + "asked", "number that was requested: picked or failed"},
                {at + "picked", "number of picks"}},
               keys);
    AddColumns(
        IntervalKeys(at + "picked_ci95", "95 % interval of picked / asked; bins are the units"),
        keys);
    keys.push_back({at + "failures.REASON", "number of failures with this reason"});
    AddColumns(IntervalKeys(at + "failures_ci95.REASON", "95 % interval of failures / asked"),
               keys);
  }
  for (const std::string group : {"success", "cleared"}) {
    const std::string at = "rows[]." + group + ".";
    const std::string what = group == "success" ? "successful attempts" : "picked instances";
    AddColumns({{at + "before", "share of " + what + " in the run", "0..1"},
                {at + "after", "share with ground truth for the stage", "0..1"},
                {at + "gain", "after - before"}},
               keys);
    AddColumns(IntervalKeys(at + "gain_ci95", "95 % interval of gain, paired over bins"), keys);
  }
  for (ResultColumn key : ForecastKeys()) {
    key.name = "pick_forecasts[]." + key.name;
    keys.push_back(std::move(key));
  }
  return keys;
}

ResultColumns BudgetColumns() {
  return {
      {"truth_for", "as_run, or the stage that ground truth replaced"},
      {"stage", "stage that the reason is attributed to"},
      {"reason", "failure reason, or all, picked, not_asked"},
      {"attempts", "number of attempts"},
      {"instances", "number of instances"},
      {"attempts_low", "lower end of the 95 % interval of the share of attempts", "0..1"},
      {"attempts_high", "upper end of the 95 % interval of the share of attempts", "0..1"},
      {"instances_low", "lower end of the 95 % interval of the share of instances", "0..1"},
      {"instances_high", "upper end of the 95 % interval of the share of instances", "0..1"},
  };
}

std::string BudgetCsv(const BudgetRuns& runs) {
  std::string csv = HeaderLine(BudgetColumns()) + CsvOf(kAsRun, runs.as_run);
  for (const OracleRerun& rerun : runs.reruns) csv += CsvOf(rerun.row.name, rerun.trials);
  return csv;
}

std::string WriteBudget(const std::filesystem::path& folder, const std::string& name,
                        const BudgetRuns& runs) {
  std::filesystem::create_directories(folder);
  WriteFileAtomically(folder / kBudgetJsonFile, BudgetJson(runs));
  WriteFileAtomically(folder / kBudgetFile, BudgetCsv(runs));
  WritePng(folder / kAttemptsSheet, DrawWaterfall(AttemptsWaterfall(runs)));
  WritePng(folder / kInstancesSheet, DrawWaterfall(InstancesWaterfall(runs)));
  if (!runs.reruns.empty()) WritePng(folder / kGainsSheet, DrawGains(GainsOf(runs)));
  return WritePage(folder / kIndexPage, PageOf(name, runs));
}

}  // namespace pickbed::eval
