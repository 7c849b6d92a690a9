#include <fmt/format.h>

#include "eval/benchmark/crops_report.h"
#include "eval/page/vega.h"
#include "eval/stats/median_error.h"

namespace pickbed::eval {
namespace {

// Selects the statistic that a chart or table shows.
using StatisticOf = const std::vector<Cluster>& (*)(const CropStatistics& statistics);

const std::vector<Cluster>& ObjectRight(const CropStatistics& f) { return f.object_right; }
const std::vector<Cluster>& WithinTen(const CropStatistics& f) { return f.within[1]; }

std::vector<CropCell> RowsOf(const CropBenchmark& benchmark, CropStage stage) {
  std::vector<CropCell> rows = CropRows(benchmark);
  std::erase_if(rows, [&](const CropCell& row) {
    return row.stage != stage && row.stage != CropStage::kIcpOnly;
  });
  // ICP from random starts is not a look-up of orientations, so it is left out here.
  if (stage == CropStage::kNearest) {
    std::erase_if(rows, [](const CropCell& r) { return r.stage == CropStage::kIcpOnly; });
  }
  return rows;
}

ReportChart ByCondition(const CropBenchmark& benchmark, ReportChart chart, CropStage stage,
                        const std::string& y_title, StatisticOf statistic) {
  std::vector<std::string> names;
  for (const int condition : CropConditionsOf(benchmark)) {
    names.push_back(CropConditionTable()[condition].name);
  }
  std::vector<RateCurve> curves;
  for (CropCell row : RowsOf(benchmark, stage)) {
    RateCurve& curve = curves.emplace_back(RateCurve{row.method, {}});
    for (const int condition : CropConditionsOf(benchmark)) {
      row.condition = condition;
      curve.rates.push_back(ClusterRate(statistic(StatisticsOf(benchmark, row))));
    }
  }
  return RateCurves(std::move(chart), "condition", y_title, names, curves);
}

ReportChart ByAngle(const CropBenchmark& benchmark, int condition) {
  std::vector<std::string> names;
  for (const double angle_deg : kCropAngles_deg) names.push_back(fmt::format("{:.0f}", angle_deg));
  std::vector<RateCurve> curves;
  for (CropCell row : RowsOf(benchmark, CropStage::kNearest)) {
    row.condition = condition;
    RateCurve& curve = curves.emplace_back(RateCurve{row.method, {}});
    for (const std::vector<Cluster>& within : StatisticsOf(benchmark, row).within) {
      curve.rates.push_back(ClusterRate(within));
    }
  }
  const char* name = CropConditionTable()[condition].name;
  return RateCurves(
      {fmt::format("angles-{}", condition), fmt::format("Share within an angle: {}", name),
       fmt::format("Nearest neighbour without ICP; {}.", CropConditionTable()[condition].help), ""},
      "within, degrees", "share", names, curves);
}

TableCells StatisticsTable(const CropBenchmark& benchmark, int condition) {
  TableCells cells{{"method", "stage", "object right [95 %]", "within 5 deg", "10 deg [95 %]",
                    "20 deg", "40 deg", "median, deg [95 %]", "over 15 deg"}};
  for (CropCell row : CropRows(benchmark)) {
    row.condition = condition;
    const CropStatistics f = StatisticsOf(benchmark, row);
    const auto percent = [](const std::vector<Cluster>& c) { return PercentText(RateOf(c)); };
    const ErrorMedian median{MedianOf(f.angles_deg), MedianInterval(f.angles_deg)};
    cells.push_back(
        {row.method, CropStageName(row.stage),
         row.stage == CropStage::kIcpOnly ? "given" : RateText(ClusterRate(f.object_right)),
         percent(f.within[0]), RateText(ClusterRate(f.within[1])), percent(f.within[2]),
         percent(f.within[3]), MedianText(median, 2), percent(f.over_15_deg)});
  }
  return cells;
}

// Share within 10 degrees for each object under one condition, for the nearest neighbour without
// ICP.
TableCells ObjectsTable(const CropBenchmark& benchmark, const ObjectSet& objects, int condition) {
  const std::vector<CropCell> rows = RowsOf(benchmark, CropStage::kNearest);
  TableCells cells{{"object"}};
  for (const CropCell& row : rows) cells[0].push_back(row.method);
  for (size_t i = 0; i < objects.size(); ++i) {
    cells.push_back({objects[i]->name});
    for (CropCell row : rows) {
      row.condition = condition;
      row.object = ObjectId(i);
      cells.back().push_back(PercentText(RateOf(StatisticsOf(benchmark, row).within[1])));
    }
  }
  return cells;
}

constexpr const char* kAbout =
    "Each test view shows one object, whose center and scale are known to all methods. Each method "
    "estimates the object and its orientation. No test view is a template or was used for "
    "training. Crops are scaled to the size of the object, so the size gives no information. "
    "Angles are the minimum over the symmetries of the object; a pose of a wrong object is wrong. "
    "Intervals are 95 % over test views of the objects named here. oracle is the template nearest "
    "to ground truth: the upper bound of any look-up. random_starts is ICP from random "
    "orientations of the given object, without any descriptor; it keeps the result with the "
    "smallest residual.";

}  // namespace

HtmlPage CropPage(const CropBenchmark& benchmark, const ObjectSet& objects,
                  const std::string& settings) {
  HtmlPage page("Whole-object crops");
  page.Paragraph(kAbout);
  std::vector<ReportChart> charts{
      ByCondition(benchmark,
                  {"part-right", "Right object by condition", "Nearest neighbour without ICP.", ""},
                  CropStage::kNearest, "right object", ObjectRight),
      ByCondition(
          benchmark,
          {"nearest", "Within 10 degrees by condition", "Nearest neighbour without ICP.", ""},
          CropStage::kNearest, "within 10 degrees", WithinTen),
      ByCondition(benchmark,
                  {"refined", "Within 10 degrees after ICP",
                   "ICP from the nearest neighbours, and from random orientations.", ""},
                  CropStage::kNearestIcp, "within 10 degrees", WithinTen)};
  for (const int condition : CropConditionsOf(benchmark)) {
    charts.push_back(ByAngle(benchmark, condition));
  }
  page.Charts(charts);
  for (const int condition : CropConditionsOf(benchmark)) {
    const CropCondition& row = CropConditionTable()[condition];
    page.Heading(row.name);
    page.Paragraph(row.help);
    page.Table(StatisticsTable(benchmark, condition));
    page.Subheading("Within 10 degrees, by object");
    page.Table(ObjectsTable(benchmark, objects, condition));
  }
  page.Heading("Settings");
  page.Preformatted(settings);
  return page;
}

}  // namespace pickbed::eval
