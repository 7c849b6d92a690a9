#include <fmt/format.h>

#include "eval/crop_report.h"
#include "eval/report/html_page.h"
#include "eval/report/page_parts.h"
#include "eval/report_page.h"

namespace pickbed {
namespace {

// What a chart or table shows of a cell.
using FigureOf = const std::vector<Cluster>& (*)(const CropFigures& figures);

const std::vector<Cluster>& PartRight(const CropFigures& f) { return f.part_right; }
const std::vector<Cluster>& WithinTen(const CropFigures& f) { return f.within[1]; }

ReportRate RateFrom(const std::vector<Cluster>& clusters) {
  const Cluster sum = SumOf(clusters);
  return {sum.hits, sum.tries, ClusterInterval(clusters)};
}

std::vector<CropCell> RowsOf(const CropBenchmark& benchmark, CropStage stage) {
  std::vector<CropCell> rows = CropRows(benchmark);
  std::erase_if(rows, [&](const CropCell& row) {
    return row.stage != stage && row.stage != CropStage::kIcpAlone;
  });
  // Orientations alone are looked up from random starts.
  if (stage == CropStage::kNearest) {
    std::erase_if(rows, [](const CropCell& r) { return r.stage == CropStage::kIcpAlone; });
  }
  return rows;
}

ReportChart ByCondition(const CropBenchmark& benchmark, ReportChart chart, CropStage stage,
                        const std::string& y_title, FigureOf figure) {
  std::vector<std::string> names;
  for (const int condition : CropConditionsOf(benchmark)) {
    names.push_back(CropConditionTable()[condition].name);
  }
  std::vector<RateCurve> curves;
  for (CropCell row : RowsOf(benchmark, stage)) {
    RateCurve& curve = curves.emplace_back(RateCurve{row.method, {}});
    for (const int condition : CropConditionsOf(benchmark)) {
      row.condition = condition;
      curve.rates.push_back(RateFrom(figure(FiguresOf(benchmark, row))));
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
    for (const std::vector<Cluster>& within : FiguresOf(benchmark, row).within) {
      curve.rates.push_back(RateFrom(within));
    }
  }
  const char* name = CropConditionTable()[condition].name;
  return RateCurves(
      {fmt::format("angles-{}", condition), fmt::format("Share within an angle: {}", name),
       fmt::format("Nearest neighbour alone; {}.", CropConditionTable()[condition].help), ""},
      "within, degrees", "share", names, curves);
}

TableCells FiguresTable(const CropBenchmark& benchmark, int condition) {
  TableCells cells{{"method", "stage", "part right [95 %]", "within 5 deg", "10 deg [95 %]",
                    "20 deg", "40 deg", "median, deg [95 %]", "over 15 deg"}};
  for (CropCell row : CropRows(benchmark)) {
    row.condition = condition;
    const CropFigures f = FiguresOf(benchmark, row);
    const auto percent = [](const std::vector<Cluster>& c) {
      return fmt::format("{:.1f} %", 100 * RateOf(c));
    };
    const Interval median = MedianInterval(f.angles_deg);
    cells.push_back(
        {row.method, CropStageName(row.stage),
         row.stage == CropStage::kIcpAlone ? "given" : RateText(RateFrom(f.part_right)),
         percent(f.within[0]), RateText(RateFrom(f.within[1])), percent(f.within[2]),
         percent(f.within[3]),
         fmt::format("{:.2f} [{:.2f}, {:.2f}]", MedianOf(f.angles_deg), median.low, median.high),
         percent(f.over_15_deg)});
  }
  return cells;
}

// Share within 10 degrees of each part under one condition, nearest neighbour alone.
TableCells PartsTable(const CropBenchmark& benchmark, const ObjectSet& objects, int condition) {
  const std::vector<CropCell> rows = RowsOf(benchmark, CropStage::kNearest);
  TableCells cells{{"part"}};
  for (const CropCell& row : rows) cells[0].push_back(row.method);
  for (size_t i = 0; i < objects.size(); ++i) {
    cells.push_back({objects[i]->name});
    for (CropCell row : rows) {
      row.condition = condition;
      row.object = static_cast<int>(i);
      cells.back().push_back(
          fmt::format("{:.1f} %", 100 * RateOf(FiguresOf(benchmark, row).within[1])));
    }
  }
  return cells;
}

std::string Section(const std::string& title, const std::string& text) {
  return fmt::format("<h2>{}</h2>\n<p>{}</p>\n", EscapeHtml(title), EscapeHtml(text));
}

constexpr const char* kAbout =
    "Each test view shows one part, whose centre and scale are known to all methods: what is asked "
    "is which part it is and how it is turned. No view is a template or was learned from. Crops "
    "are scaled to the part's size, so that size tells nothing. Angles are the least over the "
    "part's symmetries; where the wrong part is named, the pose is wrong. Intervals are 95 % over "
    "test views; the parts are the ones named here. oracle is the template nearest to the truth, "
    "the ceiling of any look-up; random_starts is ICP alone, told the part, from random "
    "orientations, of which the best result by its own measure is kept.";

}  // namespace

std::string CropPage(const CropBenchmark& benchmark, const ObjectSet& objects,
                     const std::string& settings) {
  const std::string title = "Whole-object crops";
  std::string body = fmt::format("<h1>{}</h1>\n<p>{}</p>\n", title, EscapeHtml(kAbout));
  body += "<div class=\"charts\">\n";
  for (const ReportChart& chart :
       {ByCondition(benchmark,
                    {"part-right", "Right part by condition", "Nearest neighbour alone.", ""},
                    CropStage::kNearest, "right part", PartRight),
        ByCondition(benchmark,
                    {"nearest", "Within 10 degrees by condition", "Nearest neighbour alone.", ""},
                    CropStage::kNearest, "within 10 degrees", WithinTen),
        ByCondition(benchmark,
                    {"refined", "Within 10 degrees after ICP",
                     "ICP from the nearest neighbours, and from random starts.", ""},
                    CropStage::kNearestIcp, "within 10 degrees", WithinTen)}) {
    body += ChartHtml(chart);
  }
  for (const int condition : CropConditionsOf(benchmark)) {
    body += ChartHtml(ByAngle(benchmark, condition));
  }
  body += "</div>\n";
  for (const int condition : CropConditionsOf(benchmark)) {
    const CropCondition& row = CropConditionTable()[condition];
    body += Section(row.name, row.help) + TableHtml(FiguresTable(benchmark, condition)) +
            "<h3>Within 10 degrees, part by part</h3>\n" +
            TableHtml(PartsTable(benchmark, objects, condition));
  }
  body += fmt::format("<h2>Settings</h2>\n<pre>{}</pre>\n", EscapeHtml(settings));
  return FilledPage(title, body);
}

}  // namespace pickbed
