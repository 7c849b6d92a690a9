// Text table, CSV and page of the results in eval/benchmark/bins.h.

#include <fmt/format.h>

#include <algorithm>

#include "eval/benchmark/bins.h"
#include "eval/page/vega.h"
#include "eval/stats/statistics.h"
#include "eval/summary/run_summary.h"

namespace pickbed::eval {
namespace {

// Reference curve behind all others: the default estimator in its accurate mode.
constexpr const char* kReference = "descriptor:accurate";
constexpr int kSmallChart_px = 160;  // height

// Statistics of one estimator over one or more scenarios.
struct MethodStatistics {
  std::vector<Cluster> recalls, tops;       // one per bin
  std::vector<std::vector<Cluster>> bands;  // [band][bin]
  double seconds = 0, ap = 0, ar = 0;       // means
  double memory_mib = 0, setup_s = 0;       // maximum, mean
};

MethodStatistics StatisticsOf(const std::vector<const BinRow*>& rows) {
  MethodStatistics f;
  f.bands.resize(EmptyRecallBands().size());
  for (const BinRow* row : rows) {
    for (const BinStatistics& bin : row->bins) {
      f.recalls.push_back(SumOf(bin.bands));
      f.tops.push_back({bin.top_right, 1});
      for (size_t b = 0; b < f.bands.size(); ++b) f.bands[b].push_back(bin.bands[b]);
      f.seconds += bin.seconds;
    }
    f.ap += row->ap / static_cast<double>(rows.size());
    f.ar += row->ar / static_cast<double>(rows.size());
    f.setup_s += row->setup_s / static_cast<double>(rows.size());
    f.memory_mib = std::max(f.memory_mib, row->memory_mib);
  }
  if (!f.tops.empty()) f.seconds /= static_cast<double>(f.tops.size());
  return f;
}

// Estimator labels, in the order of the first scenario.
std::vector<std::string> Labels(const std::vector<BinScenario>& scenarios) {
  std::vector<std::string> labels;
  if (scenarios.empty()) return labels;
  for (const BinRow& row : scenarios.front().rows) labels.push_back(row.label);
  return labels;
}

// Rows of one estimator, in all scenarios or in the named one.
std::vector<const BinRow*> RowsOf(const std::vector<BinScenario>& scenarios,
                                  const std::string& label, const std::string& scenario = "") {
  std::vector<const BinRow*> rows;
  for (const BinScenario& s : scenarios) {
    if (!scenario.empty() && s.name != scenario) continue;
    for (const BinRow& row : s.rows) {
      if (row.label == label) rows.push_back(&row);
    }
  }
  return rows;
}

std::string Rate(const std::vector<Cluster>& clusters) {
  const ReportRate rate = ClusterRate(clusters);
  if (rate.samples == 0) return "-";
  return rate.ci95.is_known()
             ? fmt::format("{} {}", PercentNumber(rate.rate()), IntervalText(rate.ci95))
             : PercentNumber(rate.rate());
}

std::string BandName(const RecallBand& band) {
  return VisibleBand{band.visible_min, band.visible_max}.name();
}

// Header, then one line per estimator.
TableCells MainTable(const std::vector<BinScenario>& scenarios) {
  TableCells table{{"estimator", "recall, %", "top-ranked pose right, %", "AP", "AR", "s per image",
                    "memory, MiB", "s to load"}};
  for (const std::string& label : Labels(scenarios)) {
    const MethodStatistics f = StatisticsOf(RowsOf(scenarios, label));
    table.push_back({label, Rate(f.recalls), Rate(f.tops), fmt::format("{:.3f}", f.ap),
                     fmt::format("{:.3f}", f.ar), fmt::format("{:.2f}", f.seconds),
                     fmt::format("{:.0f}", f.memory_mib), fmt::format("{:.1f}", f.setup_s)});
  }
  return table;
}

TableCells BandTable(const std::vector<BinScenario>& scenarios) {
  TableCells table{{"recall, %"}};
  for (const RecallBand& band : EmptyRecallBands())
    table.front().push_back(BandName(band) + " % visible");
  for (const std::string& label : Labels(scenarios)) {
    const MethodStatistics f = StatisticsOf(RowsOf(scenarios, label));
    table.push_back({label});
    for (const auto& band : f.bands) table.back().push_back(Rate(band));
  }
  return table;
}

// Removes the prefix bin_ of the presets, so that a dozen columns fit on the page.
std::string ShortName(const std::string& scenario) {
  constexpr std::string_view kPrefix = "bin_";
  return scenario.starts_with(kPrefix) ? scenario.substr(kPrefix.size()) : scenario;
}

// One line per estimator, one column per scenario.
TableCells ScenarioTable(const std::vector<BinScenario>& scenarios) {
  TableCells table{{"recall, %"}};
  for (const BinScenario& scenario : scenarios) table.front().push_back(ShortName(scenario.name));
  for (const std::string& label : Labels(scenarios)) {
    table.push_back({label});
    for (const BinScenario& scenario : scenarios) {
      const MethodStatistics f = StatisticsOf(RowsOf(scenarios, label, scenario.name));
      table.back().push_back(PercentNumber(RateOf(f.recalls)));
    }
  }
  return table;
}

bool HasReference(const std::vector<BinScenario>& scenarios) {
  return !RowsOf(scenarios, kReference).empty();
}

RateCurve RecallCurve(const std::vector<BinScenario>& scenarios, const std::string& label) {
  RateCurve curve{label, {}};
  const MethodStatistics f = StatisticsOf(RowsOf(scenarios, label));
  for (const std::vector<Cluster>& band : f.bands) curve.rates.push_back(ClusterRate(band));
  return curve;
}

// One chart per estimator, because eleven curves in one chart hide each other. Every chart has the
// reference curve in the background, except the chart of the reference.
std::vector<ReportChart> RecallCharts(const std::vector<BinScenario>& scenarios) {
  std::vector<std::string> bands;
  for (const RecallBand& band : EmptyRecallBands()) bands.push_back(BandName(band));
  const RateCurve reference = RecallCurve(scenarios, kReference);
  std::vector<ReportChart> charts;
  for (const std::string& label : Labels(scenarios)) {
    const bool over = HasReference(scenarios) && label != kReference;
    const std::string id = fmt::format("recall-{}", charts.size());
    charts.push_back(RateCurves({id, label, "", ""}, "visible, %", "recall", bands,
                                {RecallCurve(scenarios, label)},
                                {kSmallChart_px, over ? &reference : nullptr}));
  }
  return charts;
}

// Recall gain of the siamese term over plain regression on the same bins. Empty if either estimator
// is missing.
std::string SiameseGain(const std::vector<BinScenario>& scenarios) {
  const MethodStatistics with = StatisticsOf(RowsOf(scenarios, "doumanoglou"));
  const MethodStatistics without = StatisticsOf(RowsOf(scenarios, "doumanoglou, no siamese term"));
  if (with.recalls.empty() || with.recalls.size() != without.recalls.size()) return "";
  const Interval interval = PairedInterval(without.recalls, with.recalls);
  const double gain = RateOf(with.recalls) - RateOf(without.recalls);
  return fmt::format(
      "The siamese term raises the recall of regression by {} percentage points over {} "
      "bins.",
      PointsText(gain, interval), with.recalls.size());
}

int BinsOf(const std::vector<BinScenario>& scenarios) {
  return static_cast<int>(StatisticsOf(RowsOf(scenarios, Labels(scenarios).front())).tops.size());
}

}  // namespace

ResultColumns BinTableColumns() {
  ResultColumns columns{
      {"scenario", "name of the scenario, or all"},
      {"estimator", "row of the table: estimator, mode and model"},
      {"bins", "number of images, one per bin"},
      {"top_right", "number of images whose highest-ranked pose is correct"},
      {"recalled", "number of instances with a correct pose"},
      {"instances", "number of instances with a visible fraction of at least 0.1"},
      {"ap", "BOP24 average precision", "0..1"},
      {"ar", "BOP19 average recall", "0..1"},
      {"seconds", "mean duration of an estimate"},
      {"memory_mib", "peak memory of the process"},
  };
  for (const RecallBand& band : EmptyRecallBands()) {
    const double low = 100 * band.visible_min, high = 100 * band.visible_max;
    AddColumns(
        {{fmt::format("recalled_{:.0f}_{:.0f}", low, high), "number of these with a correct pose"},
         {fmt::format("instances_{:.0f}_{:.0f}", low, high),
          fmt::format("number of instances that are {:.0f} to {:.0f} % visible", low, high)}},
        columns);
  }
  return columns;
}

std::string BinTableCsv(const std::vector<BinScenario>& scenarios) {
  std::string csv = HeaderLine(BinTableColumns());
  const auto line = [&](const std::string& scenario, const std::string& label,
                        const MethodStatistics& f) {
    const Cluster all = SumOf(f.recalls);
    csv += fmt::format("{},\"{}\",{},{},{},{},{:.4f},{:.4f},{:.4f},{:.1f}", scenario, label,
                       f.tops.size(), SumOf(f.tops).hits, all.hits, all.samples, f.ap, f.ar,
                       f.seconds, f.memory_mib);
    for (const auto& band : f.bands) {
      csv += fmt::format(",{},{}", SumOf(band).hits, SumOf(band).samples);
    }
    csv += "\n";
  };
  for (const std::string& label : Labels(scenarios)) {
    line("all", label, StatisticsOf(RowsOf(scenarios, label)));
  }
  for (const BinScenario& scenario : scenarios) {
    for (const BinRow& row : scenario.rows) line(scenario.name, row.label, StatisticsOf({&row}));
  }
  return csv;
}

std::string BinTableText(const std::vector<BinScenario>& scenarios, const std::string& note) {
  std::string text;
  for (const std::vector<std::string>& line : MainTable(scenarios)) {
    text += fmt::format("{:<30}", line.front());
    for (size_t i = 1; i < line.size(); ++i) text += fmt::format("{:>25}", line[i]);
    text += "\n";
  }
  for (const std::string& line : {SiameseGain(scenarios), note}) {
    if (!line.empty()) text += line + "\n";
  }
  return text;
}

HtmlPage BinTablePage(const std::vector<BinScenario>& scenarios, const std::string& note) {
  HtmlPage page("Pose estimators in bins");
  page.Paragraph(
      "All estimators got the same images. A pose is right if its MSSD is under a tenth of the "
      "object's diameter; instances at least 10 % visible are to be found. In brackets: 95 % "
      "intervals over bins. Kehl, Doumanoglou and the verified point pair features share sampling, "
      "ICP, verifier and pose selection with the descriptors; they differ in the proposal of "
      "poses.");
  page.Paragraph(note);
  page.Paragraph(FewBinsText(BinsOf(scenarios)));
  page.Table(MainTable(scenarios));
  page.Paragraph(SiameseGain(scenarios));
  page.Heading("By visible fraction");
  if (HasReference(scenarios)) {
    page.Paragraph(fmt::format("Bars: 95 % intervals. Grey: {}.", kReference));
  }
  page.SmallCharts(RecallCharts(scenarios));
  page.Table(BandTable(scenarios));
  page.Heading("By scenario");
  page.Table(ScenarioTable(scenarios));
  return page;
}

}  // namespace pickbed::eval
