// Table, CSV and page of eval/benchmark_bins.h.

#include <fmt/format.h>

#include <algorithm>

#include "eval/benchmark_bins.h"
#include "eval/few_bins.h"
#include "eval/report/html_page.h"
#include "eval/summary.h"

namespace pickbed {
namespace {

// The estimator that all others are drawn over: the default one, as thorough as they are.
constexpr const char* kReference = "descriptor:hard";

// Of one estimator, in some scenarios.
struct Figures {
  std::vector<Cluster> recalls, tops;       // by bin
  std::vector<std::vector<Cluster>> bands;  // by band and bin
  double seconds = 0, ap = 0, ar = 0;       // means
  double memory_mib = 0, setup_s = 0;       // most, mean
};

Figures FiguresOf(const std::vector<const BinRow*>& rows) {
  Figures f;
  f.bands.resize(EmptyRecallBands().size());
  for (const BinRow* row : rows) {
    for (const BinLook& look : row->looks) {
      f.recalls.push_back(SumOf(look.bands));
      f.tops.push_back({look.top_right, 1});
      for (size_t b = 0; b < f.bands.size(); ++b) f.bands[b].push_back(look.bands[b]);
      f.seconds += look.seconds;
    }
    f.ap += row->ap / static_cast<double>(rows.size());
    f.ar += row->ar / static_cast<double>(rows.size());
    f.setup_s += row->setup_s / static_cast<double>(rows.size());
    f.memory_mib = std::max(f.memory_mib, row->memory_mib);
  }
  if (!f.tops.empty()) f.seconds /= static_cast<double>(f.tops.size());
  return f;
}

// Labels in the order of the first scenario.
std::vector<std::string> Labels(const std::vector<BinScenario>& scenarios) {
  std::vector<std::string> labels;
  for (const BinRow& row : scenarios.front().rows) labels.push_back(row.label);
  return labels;
}

// Of all scenarios, or of one.
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
  const Cluster sum = SumOf(clusters);
  if (sum.tries == 0) return "-";
  const Interval interval = ClusterInterval(clusters);
  return fmt::format("{:.1f} [{:.1f}, {:.1f}]", 100 * RateOf(clusters), 100 * interval.low,
                     100 * interval.high);
}

std::string BandName(const RecallBand& band) {
  return fmt::format("{:.0f}-{:.0f} % visible", 100 * band.visible_min, 100 * band.visible_max);
}

// The header first, then a line an estimator.
std::vector<std::vector<std::string>> MainTable(const std::vector<BinScenario>& scenarios) {
  std::vector<std::vector<std::string>> table{{"estimator", "recall, %", "top-ranked pose right, %",
                                               "AP", "AR", "s an image", "memory, MiB",
                                               "s to load"}};
  for (const std::string& label : Labels(scenarios)) {
    const Figures f = FiguresOf(RowsOf(scenarios, label));
    table.push_back({label, Rate(f.recalls), Rate(f.tops), fmt::format("{:.3f}", f.ap),
                     fmt::format("{:.3f}", f.ar), fmt::format("{:.2f}", f.seconds),
                     fmt::format("{:.0f}", f.memory_mib), fmt::format("{:.1f}", f.setup_s)});
  }
  return table;
}

std::vector<std::vector<std::string>> BandTable(const std::vector<BinScenario>& scenarios) {
  std::vector<std::vector<std::string>> table{{"recall, %"}};
  for (const RecallBand& band : EmptyRecallBands()) table.front().push_back(BandName(band));
  for (const std::string& label : Labels(scenarios)) {
    const Figures f = FiguresOf(RowsOf(scenarios, label));
    table.push_back({label});
    for (const auto& band : f.bands) table.back().push_back(Rate(band));
  }
  return table;
}

// A dozen columns fit on a page where the presets' bin_ is left out.
std::string ShortName(const std::string& scenario) {
  constexpr std::string_view kPrefix = "bin_";
  return scenario.starts_with(kPrefix) ? scenario.substr(kPrefix.size()) : scenario;
}

// A line an estimator, a column a scenario.
std::vector<std::vector<std::string>> ScenarioTable(const std::vector<BinScenario>& scenarios) {
  std::vector<std::vector<std::string>> table{{"recall, %"}};
  for (const BinScenario& scenario : scenarios) table.front().push_back(ShortName(scenario.name));
  for (const std::string& label : Labels(scenarios)) {
    table.push_back({label});
    for (const BinScenario& scenario : scenarios) {
      const Figures f = FiguresOf(RowsOf(scenarios, label, scenario.name));
      table.back().push_back(fmt::format("{:.1f}", 100 * RateOf(f.recalls)));
    }
  }
  return table;
}

Curve RecallCurve(const std::vector<BinScenario>& scenarios, const std::string& label) {
  Curve curve{label, {}};
  const Figures f = FiguresOf(RowsOf(scenarios, label));
  const std::vector<RecallBand> bands = EmptyRecallBands();
  for (size_t b = 0; b < bands.size(); ++b) {
    if (SumOf(f.bands[b]).tries == 0) continue;
    const Interval interval = ClusterInterval(f.bands[b]);
    curve.points.push_back({50 * (bands[b].visible_min + bands[b].visible_max),
                            100 * RateOf(f.bands[b]), 100 * interval.low, 100 * interval.high});
  }
  return curve;
}

// A chart an estimator: eleven curves in one hide each other. Behind each stands the reference, in
// its own chart that of nothing.
std::vector<CurveChart> RecallCharts(const std::vector<BinScenario>& scenarios) {
  std::vector<CurveChart> charts;
  for (const std::string& label : Labels(scenarios)) {
    CurveChart& chart =
        charts.emplace_back(CurveChart{label, "visible, %", "recall, %", 0, 100, 0, 100});
    chart.curves = {RecallCurve(scenarios, label)};
    if (label != kReference) chart.behind = RecallCurve(scenarios, kReference);
  }
  return charts;
}

// What the siamese term adds to plain regression on the same bins; empty where either is missing.
std::string SiameseGain(const std::vector<BinScenario>& scenarios) {
  const Figures with = FiguresOf(RowsOf(scenarios, "doumanoglou"));
  const Figures without = FiguresOf(RowsOf(scenarios, "doumanoglou, no siamese term"));
  if (with.recalls.empty() || with.recalls.size() != without.recalls.size()) return "";
  const Interval interval = PairedInterval(without.recalls, with.recalls);
  return fmt::format(
      "The siamese term raises the recall of regression by {:+.1f} points, 95 % interval "
      "[{:+.1f}, {:+.1f}] over {} bins.",
      100 * (RateOf(with.recalls) - RateOf(without.recalls)), 100 * interval.low,
      100 * interval.high, with.recalls.size());
}

int BinsOf(const std::vector<BinScenario>& scenarios) {
  return static_cast<int>(FiguresOf(RowsOf(scenarios, Labels(scenarios).front())).tops.size());
}

}  // namespace

std::string BinTableCsv(const std::vector<BinScenario>& scenarios) {
  std::string csv = "scenario,estimator,bins,top_right,recalled,instances,ap,ar,seconds,memory_mib";
  for (const RecallBand& band : EmptyRecallBands()) {
    csv += fmt::format(",recalled_{0:.0f}_{1:.0f},instances_{0:.0f}_{1:.0f}",
                       100 * band.visible_min, 100 * band.visible_max);
  }
  csv += "\n";
  const auto line = [&](const std::string& scenario, const std::string& label, const Figures& f) {
    const Cluster all = SumOf(f.recalls);
    csv += fmt::format("{},\"{}\",{},{},{},{},{:.4f},{:.4f},{:.4f},{:.1f}", scenario, label,
                       f.tops.size(), SumOf(f.tops).hits, all.hits, all.tries, f.ap, f.ar,
                       f.seconds, f.memory_mib);
    for (const auto& band : f.bands) {
      csv += fmt::format(",{},{}", SumOf(band).hits, SumOf(band).tries);
    }
    csv += "\n";
  };
  for (const std::string& label : Labels(scenarios)) {
    line("all", label, FiguresOf(RowsOf(scenarios, label)));
  }
  for (const BinScenario& scenario : scenarios) {
    for (const BinRow& row : scenario.rows) line(scenario.name, row.label, FiguresOf({&row}));
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

std::string BinTablePage(const std::vector<BinScenario>& scenarios, const std::string& note) {
  HtmlPage page("Pose estimators in bins");
  page.Paragraph(
      "All estimators saw the same images. A pose is right when its MSSD is under a tenth of the "
      "part's diameter; instances of at least 10 % visible are to be found. In brackets: 95 % "
      "intervals over bins. Kehl, Doumanoglou and the verified point pair features share sampling, "
      "ICP, verifier and final set with the descriptors; what differs is who proposes poses.");
  if (!note.empty()) page.Paragraph(note);
  if (const std::string few = FewBinsText(BinsOf(scenarios)); !few.empty()) page.Paragraph(few);
  page.Table(MainTable(scenarios));
  if (const std::string gain = SiameseGain(scenarios); !gain.empty()) page.Paragraph(gain);
  page.Heading("By visible fraction");
  if (const Curve behind = RecallCurve(scenarios, kReference); !behind.points.empty()) {
    page.Paragraph(fmt::format("Shaded: 95 % intervals. Grey: {}.", kReference));
  }
  page.SmallCharts(RecallCharts(scenarios));
  page.Table(BandTable(scenarios));
  page.Heading("By scenario");
  page.Table(ScenarioTable(scenarios));
  return page.Finish();
}

}  // namespace pickbed
