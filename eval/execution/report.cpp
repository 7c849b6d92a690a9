#include "eval/execution/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "eval/metrics/interval_json.h"
#include "eval/page/vega.h"

namespace pickbed::eval {
namespace {

std::string Aligned(const TableCells& rows) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) line += fmt::format(" {:<{}} ", row[i], widths[i]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

TableCells SuccessCells(const ExecutionStatistics& statistics) {
  TableCells cells{{"method", "requested", "picked [95 %]", "executed", "success [95 %]"}};
  for (const MethodStatistics& method : statistics.methods) {
    cells.push_back({method.method, std::to_string(method.requested.samples),
                     RateText(method.requested), std::to_string(method.executed.samples),
                     RateText(method.executed)});
  }
  return cells;
}

// One row per reason that occurs, in the order of the table of reasons.
TableCells FailureCells(const ExecutionStatistics& statistics) {
  TableCells cells{{"failure reason", "stage"}};
  for (const MethodStatistics& method : statistics.methods) cells[0].push_back(method.method);
  for (const FailureRow& row : FailureTable()) {
    std::vector<std::string> line{std::string(row.name), std::string(StageName(row.stage))};
    bool occurs = false;
    for (const MethodStatistics& method : statistics.methods) {
      const auto found = method.failures.find(row.failure);
      const bool is_here = found != method.failures.end();
      occurs = occurs || is_here;
      line.push_back(
          is_here ? fmt::format("{} ({})", found->second.hits, PercentText(found->second.rate()))
                  : "0");
    }
    if (occurs) cells.push_back(std::move(line));
  }
  return cells;
}

const PredictorAuc* AucNamed(const std::vector<PredictorAuc>& predictors, const std::string& name) {
  for (const PredictorAuc& predictor : predictors) {
    if (predictor.name == name) return &predictor;
  }
  return nullptr;
}

std::string AucCell(const PredictorAuc* predictor) {
  if (predictor == nullptr) return "-";
  return predictor->auc.is_known() ? AucText(predictor->auc) : "- (one outcome only)";
}

TableCells PredictorCells(const ExecutionStatistics& statistics) {
  TableCells cells{{"AUC of"}};
  for (const MethodStatistics& method : statistics.methods) cells[0].push_back(method.method);
  const bool several = statistics.methods.size() > 1;
  if (several) cells[0].push_back("all methods");
  for (const OutcomePredictor& row : OutcomePredictors()) {
    std::vector<std::string> line{row.title};
    for (const MethodStatistics& method : statistics.methods) {
      line.push_back(AucCell(AucNamed(method.predictors, row.name)));
    }
    if (several) line.push_back(AucCell(AucNamed(statistics.predictors, row.name)));
    cells.push_back(std::move(line));
  }
  return cells;
}

ReportChart SuccessChart(const ExecutionStatistics& statistics) {
  std::vector<std::string> names;
  RateCurve requested{"requested picks", {}}, executed{"executed grasps", {}};
  for (const MethodStatistics& method : statistics.methods) {
    names.push_back(method.method);
    requested.rates.push_back(method.requested);
    executed.rates.push_back(method.executed);
  }
  return RateCurves({"success", "Success by method",
                     "Bars: 95 % intervals over scenes. A requested pick without a grasp counts as "
                     "a failure.",
                     ""},
                    "method", "success", names, {requested, executed},
                    {.x_names = AxisNames::kCategories});
}

ReportChart PickChart(const ExecutionStatistics& statistics) {
  std::vector<RateCurve> curves;
  size_t picks = 0;
  for (const MethodStatistics& method : statistics.methods) {
    curves.push_back({method.method, method.by_pick});
    picks = std::max(picks, method.by_pick.size());
  }
  std::vector<std::string> names;
  for (size_t i = 1; i <= picks; ++i) names.push_back(std::to_string(i));
  for (RateCurve& curve : curves) curve.rates.resize(picks);
  return RateCurves({"by-pick", "Success of the first, second, ... pick of an image",
                     "Each pick starts from the scene that the image shows.", ""},
                    "pick", "success", names, curves);
}

ReportChart PredictorChart(const ExecutionStatistics& statistics) {
  std::vector<std::string> names;
  for (const OutcomePredictor& row : OutcomePredictors()) names.push_back(row.title);
  std::vector<NamedValueCurve> curves;
  for (const MethodStatistics& method : statistics.methods) {
    NamedValueCurve& curve = curves.emplace_back();
    curve.series = method.method;
    for (const PredictorAuc& predictor : method.predictors) {
      const AucResult& auc = predictor.auc;
      curve.values.push_back(auc.is_known() ? auc.auc : std::nan(""));
      curve.intervals.push_back(auc.is_known() ? auc.interval : Interval::Unknown());
      curve.texts.push_back(AucCell(&predictor));
      curve.samples.push_back(auc.successes + auc.failures);
    }
  }
  return NamedValueCurves({"auc", "How well errors predict the outcome of a pick",
                           "Area under the ROC curve over the executed picks: 0.5 is chance, 1 is "
                           "a perfect prediction. "
                           "Bars: 95 % intervals over scenes.",
                           ""},
                          "error of the pose", "AUC", names, curves, 1, AxisNames::kCategories);
}

nlohmann::ordered_json RateObject(const ReportRate& rate) {
  nlohmann::ordered_json json{
      {"successes", rate.hits}, {"picks", rate.samples}, {"rate", rate.rate()}};
  AddInterval(json, "ci95", rate.ci95);
  return json;
}

nlohmann::ordered_json PredictorObject(const std::vector<PredictorAuc>& predictors) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const PredictorAuc& predictor : predictors) {
    nlohmann::ordered_json entry;
    if (predictor.auc.is_known()) {
      entry["auc"] = predictor.auc.auc;
      AddInterval(entry, "ci95", predictor.auc.interval);
    } else {
      entry["auc"] = nullptr;
      AddInterval(entry, "ci95", Interval::Unknown());
    }
    json[predictor.name] = std::move(entry);
  }
  return json;
}

void AddRateKeys(const std::string& at, const std::string& what, ResultColumns& keys) {
  AddColumns({{at + ".successes", "number of successful picks among " + what},
              {at + ".picks", "number of " + what},
              {at + ".rate", "successes / picks", "0..1"}},
             keys);
  AddColumns(IntervalKeys(at + ".ci95", "95 % interval of rate over scenes"), keys);
}

void AddPredictorKeys(const std::string& at, const std::string& picks, ResultColumns& keys) {
  AddColumns({{at + ".PREDICTOR.auc",
               "area under the ROC curve of the predictor (vsd, mssd, mspd, add, adi, score or "
               "visible) on " +
                   picks + "; null without both outcomes",
               "0..1"}},
             keys);
  AddColumns(IntervalKeys(at + ".PREDICTOR.ci95", "95 % interval of auc over scenes"), keys);
}

}  // namespace

std::string ExecutionText(const ExecutionStatistics& statistics) {
  std::string text =
      fmt::format("{} picks in {} images of {} scenes\n{}\n", statistics.picks, statistics.images,
                  statistics.scenes, Aligned(SuccessCells(statistics)));
  const TableCells failures = FailureCells(statistics);
  if (failures.size() > 1) text += Aligned(failures) + "\n";
  text += Aligned(PredictorCells(statistics));
  if (!statistics.paired.empty()) text += "\n" + ComparisonText(statistics.paired, true);
  const std::string few = FewBinsText(statistics.scenes);
  return few.empty() ? text : text + few + "\n";
}

std::string ExecutionJson(const ExecutionStatistics& statistics) {
  nlohmann::ordered_json json{
      {"scenes", statistics.scenes}, {"images", statistics.images}, {"picks", statistics.picks}};
  json["methods"] = nlohmann::ordered_json::array();
  for (const MethodStatistics& method : statistics.methods) {
    nlohmann::ordered_json entry{{"method", method.method},
                                 {"requested", RateObject(method.requested)},
                                 {"executed", RateObject(method.executed)}};
    entry["by_pick"] = nlohmann::ordered_json::array();
    for (const ReportRate& rate : method.by_pick) entry["by_pick"].push_back(RateObject(rate));
    entry["failures"] = nlohmann::ordered_json::object();
    for (const auto& [reason, rate] : method.failures) {
      nlohmann::ordered_json failure{{"picks", rate.hits}, {"share", rate.rate()}};
      AddInterval(failure, "ci95", rate.ci95);
      entry["failures"][std::string(FailureName(reason))] = std::move(failure);
    }
    entry["predictors"] = PredictorObject(method.predictors);
    json["methods"].push_back(std::move(entry));
  }
  json["predictors"] = PredictorObject(statistics.predictors);
  json.update(nlohmann::ordered_json::parse(ComparisonJson(statistics.paired)));
  return json.dump(2) + "\n";
}

ResultColumns ExecutionKeys() {
  ResultColumns keys{{"scenes", "number of scenes"},
                     {"images", "number of images with a requested pick"},
                     {"picks", "number of requested picks of all methods"},
                     {"methods[].method", "name of the method"}};
  AddRateKeys("methods[].requested", "requested picks", keys);
  AddRateKeys("methods[].executed", "executed grasps", keys);
  AddRateKeys("methods[].by_pick[]", "first, second, ... picks of the images", keys);
  AddColumns({{"methods[].failures.REASON.picks", "number of requested picks with this reason"},
              {"methods[].failures.REASON.share", "share of the requested picks", "0..1"}},
             keys);
  AddColumns(IntervalKeys("methods[].failures.REASON.ci95", "95 % interval of share over scenes"),
             keys);
  AddPredictorKeys("methods[].predictors", "the executed picks of the method", keys);
  AddPredictorKeys("predictors", "the executed picks of all methods", keys);
  AddColumns(ComparisonKeys(), keys);
  return keys;
}

HtmlPage ExecutionPage(const ExecutionStatistics& statistics, const std::string& what) {
  HtmlPage page("Executed pose estimates");
  page.Paragraph(fmt::format(
      "{}. {} picks in {} images of {} scenes. Each pick starts from the scene that its image "
      "shows; the planner gets the image and all poses of the method.",
      what, statistics.picks, statistics.images, statistics.scenes));
  page.Note(FewBinsText(statistics.scenes));
  page.Heading("Success", "success");
  page.Table(SuccessCells(statistics));
  page.Charts({SuccessChart(statistics), PickChart(statistics)});
  const TableCells failures = FailureCells(statistics);
  if (failures.size() > 1) {
    page.Heading("Failure reasons", "failures");
    page.Paragraph("Number of requested picks with each reason, and their share.");
    page.Table(failures);
  }
  page.Heading("Pose errors and outcomes", "errors");
  page.Chart(PredictorChart(statistics));
  page.Table(PredictorCells(statistics));
  for (const ConfigurationComparison& comparison : statistics.paired) {
    const ReportTable table = PairedReport(comparison);
    page.Heading(table.title);
    page.Paragraph(table.text);
    page.Table(table.cells);
  }
  return page;
}

}  // namespace pickbed::eval
