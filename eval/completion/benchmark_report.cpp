#include "eval/completion/benchmark_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "eval/page/html.h"
#include "eval/page/vega.h"
#include "eval/shapes/completion_choice.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

struct MeasureColumn {
  const char* name;
  const char* heading;
  const char* help;
  const char* unit;
  MeasureOf value;
};
constexpr MeasureColumn kMeasures[] = {
    {"iou", "IoU", "volume in both over volume in either", "0..1",
     [](const CompletionMeasures& m) { return m.iou; }},
    {"chamfer", "Surface distance (Chamfer)",
     "mean distance between the surfaces, both directions, over the diameter", "0..1",
     [](const CompletionMeasures& m) { return m.chamfer; }},
    {"f_score", "F-score at 1 %", "F-score of surface points within 1 % of the diameter", "0..1",
     [](const CompletionMeasures& m) { return m.f_score; }},
    {"hidden_found", "Share of the hidden surface within 2 mm",
     "share of the hidden true surface within 2 mm", "0..1",
     [](const CompletionMeasures& m) { return m.hidden_found; }},
};

std::string ConditionName(bool is_occluded) { return is_occluded ? "occluded" : "clean"; }

std::string MeanText(const ShapeMean& mean) {
  if (mean.shapes == 0) return "-";
  if (!mean.ci95.is_known()) return fmt::format("{:.3f}", mean.mean);
  return fmt::format("{:.3f} [{:.3f}, {:.3f}]", mean.mean, mean.ci95.low, mean.ci95.high);
}

TableCells MeasureTable(const CompletionBenchmark& benchmark, const MeasureColumn& measure,
                        bool is_occluded) {
  TableCells table{{"method"}};
  for (const std::string& set : benchmark.sets) table.front().push_back(set);
  for (const std::string& method : benchmark.methods) {
    std::vector<std::string>& row = table.emplace_back(std::vector<std::string>{method});
    for (const std::string& set : benchmark.sets) {
      row.push_back(MeanText(MeanOverShapes(benchmark, method, set, is_occluded, measure.value)));
    }
  }
  return table;
}

TableCells DifferenceTable(const CompletionBenchmark& benchmark, bool is_occluded) {
  TableCells table{{"IoU minus IoU of"}};
  for (const std::string& set : benchmark.sets) table.front().push_back(set);
  for (size_t i = 1; i < benchmark.methods.size(); ++i) {
    const std::string& other = benchmark.methods[i];
    std::vector<std::string>& row = table.emplace_back(std::vector<std::string>{other});
    for (const std::string& set : benchmark.sets) {
      row.push_back(MeanText(DifferenceOverShapes(benchmark, benchmark.methods.front(), other, set,
                                                  is_occluded, kMeasures[0].value)));
    }
  }
  return table;
}

using Calibration = std::array<std::array<double, 3>, kCalibrationBins>;

Calibration CalibrationOf(const CompletionBenchmark& benchmark, const std::string& method,
                          const std::string& set) {
  Calibration sums{};
  for (const CompletionRow& row : benchmark.rows) {
    if (row.method != method || row.set != set) continue;
    for (int bin = 0; bin < kCalibrationBins; ++bin) {
      for (int i = 0; i < 3; ++i) sums[bin][i] += row.measures.calibration[bin][i];
    }
  }
  return sums;
}

// Share of the cells of a bin of probability that are inside the true shape. The interval is over
// shapes.
ReportRate InsideRate(const CompletionBenchmark& benchmark, const std::string& method,
                      const std::string& set, int bin) {
  // Large benchmarks have more cells than an int can count. A common factor does not change shares.
  constexpr double kMaxCounted = 1e9;
  std::map<std::string, std::pair<double, double>> by_shape;  // cells inside, all cells
  double all = 0;
  for (const CompletionRow& row : benchmark.rows) {
    if (row.method != method || row.set != set) continue;
    auto& [inside, cells] = by_shape[row.shape];
    inside += row.measures.calibration[bin][2];
    cells += row.measures.calibration[bin][0];
    all += row.measures.calibration[bin][0];
  }
  const double scale = std::max(1.0, all / kMaxCounted);
  std::vector<Cluster> clusters;
  for (const auto& [shape, counts] : by_shape) {
    clusters.push_back(
        {static_cast<int>(counts.first / scale), static_cast<int>(counts.second / scale)});
  }
  return ClusterRate(clusters);
}

// "0.89 [0.86, 0.92]", or "-" without samples.
std::string ShareText(const ReportRate& rate) {
  if (rate.samples == 0) return "-";
  if (!rate.ci95.is_known()) return fmt::format("{:.2f}", rate.rate());
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]", rate.rate(), rate.ci95.low, rate.ci95.high);
}

TableCells CalibrationTable(const CompletionBenchmark& benchmark) {
  TableCells table{{"set"}};
  for (int bin = 0; bin < kCalibrationBins; ++bin) {
    table.front().push_back(fmt::format("p {:.2f}", (bin + 0.5) / kCalibrationBins));
  }
  for (const std::string& set : benchmark.sets) {
    std::vector<std::string>& row = table.emplace_back(std::vector<std::string>{set});
    for (int bin = 0; bin < kCalibrationBins; ++bin) {
      row.push_back(ShareText(InsideRate(benchmark, benchmark.methods.front(), set, bin)));
    }
  }
  return table;
}

std::string SkippedText(const std::string& set) {
  return fmt::format("set {0} is skipped: give --data a folder with a folder {0} of meshes", set);
}

std::string TableCsv(const CompletionBenchmark& benchmark) {
  std::string csv = HeaderLine(CompletionTableColumns());
  for (const std::string& method : benchmark.methods) {
    for (const std::string& set : benchmark.sets) {
      for (const bool is_occluded : {false, true}) {
        const int shapes =
            MeanOverShapes(benchmark, method, set, is_occluded, kMeasures[0].value).shapes;
        csv += fmt::format("{},{},{},{}", method, set, ConditionName(is_occluded), shapes);
        for (const MeasureColumn& measure : kMeasures) {
          const ShapeMean mean = MeanOverShapes(benchmark, method, set, is_occluded, measure.value);
          const std::string value = shapes > 0 ? fmt::format("{:.4f}", mean.mean) : "";
          csv += fmt::format(",{},{}", value, IntervalCells(mean.ci95, 4));
        }
        csv += "\n";
      }
    }
  }
  return csv;
}

std::string ViewsCsv(const CompletionBenchmark& benchmark) {
  std::string csv = HeaderLine(CompletionViewsColumns());
  for (const CompletionRow& row : benchmark.rows) {
    csv += fmt::format("{},{},{},{},{}", row.method, row.set, CsvCell(row.shape),
                       ConditionName(row.is_occluded), row.view);
    for (const MeasureColumn& measure : kMeasures) {
      csv += fmt::format(",{:.4f}", measure.value(row.measures));
    }
    csv += "\n";
  }
  return csv;
}

std::string CalibrationCsv(const CompletionBenchmark& benchmark) {
  std::string csv = HeaderLine(CompletionCalibrationColumns());
  for (const std::string& method : benchmark.methods) {
    for (const std::string& set : benchmark.sets) {
      const Calibration sums = CalibrationOf(benchmark, method, set);
      for (int bin = 0; bin < kCalibrationBins; ++bin) {
        if (sums[bin][0] <= 0) continue;
        const ReportRate inside = InsideRate(benchmark, method, set, bin);
        csv +=
            fmt::format("{},{},{:.4f},{:.4f},{},{:.0f}\n", method, set, sums[bin][1] / sums[bin][0],
                        inside.rate(), IntervalCells(inside.ci95, 4), sums[bin][0]);
      }
    }
  }
  return csv;
}

// Median duration of a completion, with its 95 % interval over shapes.
struct MedianDuration {
  double median_s = 0;
  Interval ci95;
};

MedianDuration SecondsOf(const CompletionBenchmark& benchmark, const std::string& method) {
  std::map<std::pair<std::string, std::string>, std::vector<double>> by_shape;
  for (const CompletionRow& row : benchmark.rows) {
    if (row.method == method) by_shape[{row.set, row.shape}].push_back(row.seconds);
  }
  ValueClusters clusters;
  for (const auto& [shape, seconds] : by_shape) clusters.push_back(seconds);
  if (clusters.empty()) return {0, Interval::Unknown()};
  return {MedianOf(clusters), MedianInterval(clusters)};
}

std::string SecondsText(const MedianDuration& seconds) {
  const std::string median = fmt::format("{:.4f}", seconds.median_s);
  if (!seconds.ci95.is_known()) return median;
  return fmt::format("{} [{:.4f}, {:.4f}]", median, seconds.ci95.low, seconds.ci95.high);
}

std::string TimingsCsv(const CompletionBenchmark& benchmark) {
  std::string csv = HeaderLine(CompletionTimingsColumns());
  for (const std::string& method : benchmark.methods) {
    const MedianDuration seconds = SecondsOf(benchmark, method);
    const std::string median = seconds.median_s > 0 ? fmt::format("{:.4f}", seconds.median_s) : "";
    csv += fmt::format("{},{},{}\n", method, median, IntervalCells(seconds.ci95, 4));
  }
  return csv;
}

}  // namespace

ResultColumns CompletionTableColumns() {
  ResultColumns columns{
      {"method", "name of the completion method"},
      {"set", "name of the test set"},
      {"condition", "clean, or occluded: 20 to 50 % of the visible pixels hidden"},
      {"shapes", "number of shapes"}};
  for (const MeasureColumn& measure : kMeasures) {
    const std::string name = measure.name;
    AddColumns({{name, measure.help, measure.unit},
                {name + "_low", "lower end of its 95 % interval over shapes", measure.unit},
                {name + "_high", "upper end of its 95 % interval over shapes", measure.unit}},
               columns);
  }
  return columns;
}

ResultColumns CompletionViewsColumns() {
  ResultColumns columns{{"method", "name of the completion method"},
                        {"set", "name of the test set"},
                        {"shape", "name of the shape"},
                        {"condition", "clean or occluded"},
                        {"view", "index of the view of the shape"}};
  for (const MeasureColumn& measure : kMeasures) {
    AddColumns({{measure.name, measure.help, measure.unit}}, columns);
  }
  return columns;
}

ResultColumns CompletionCalibrationColumns() {
  return {{"method", "name of the completion method"},
          {"set", "name of the test set"},
          {"probability", "mean probability of the cells of a bin", "0..1"},
          {"inside", "share of these cells inside the true shape", "0..1"},
          {"inside_low", "lower end of its 95 % interval over shapes", "0..1"},
          {"inside_high", "upper end of its 95 % interval over shapes", "0..1"},
          {"cells", "number of cells"}};
}

ResultColumns CompletionTimingsColumns() {
  return {{"method", "name of the completion method"},
          {"seconds", "median duration of a completion", "s"},
          {"seconds_low", "lower end of its 95 % interval over shapes", "s"},
          {"seconds_high", "upper end of its 95 % interval over shapes", "s"}};
}

std::string CompletionTableText(const CompletionBenchmark& benchmark) {
  std::string text;
  for (const bool is_occluded : {false, true}) {
    text += fmt::format("IoU, {}\n  {:<17}", ConditionName(is_occluded), "");
    for (const std::string& set : benchmark.sets) text += fmt::format("{:>23}", set);
    text += "\n";
    for (const std::string& method : benchmark.methods) {
      text += fmt::format("  {:<17}", method);
      for (const std::string& set : benchmark.sets) {
        const ShapeMean mean =
            MeanOverShapes(benchmark, method, set, is_occluded, kMeasures[0].value);
        text += fmt::format("{:>23}", MeanText(mean));
      }
      text += "\n";
    }
  }
  for (const std::string& set : benchmark.skipped_sets) {
    text += fmt::format("{}\n", SkippedText(set));
  }
  return text;
}

void AddCompletionBenchmark(const std::filesystem::path& folder,
                            const CompletionBenchmark& benchmark,
                            const CompletionBenchmarkOptions& options, HtmlPage& page) {
  MakeFolder(folder);
  WriteFileAtomically(folder / kCompletionTable, TableCsv(benchmark));
  WriteFileAtomically(folder / kCompletionViews, ViewsCsv(benchmark));
  WriteFileAtomically(folder / kCompletionCalibration, CalibrationCsv(benchmark));
  WriteFileAtomically(folder / kCompletionTimings, TimingsCsv(benchmark));
  page.Paragraph(fmt::format(
      "Completions of single views with sensor {}, on {}^3 cells. Shapes are at least {:.0f} px "
      "wide, and cells with a probability above {} are full. Each shape has {} clean and as "
      "many occluded views, in which 20 to 50 % of the visible pixels are hidden. Means count each "
      "shape once; 95 % intervals are over shapes.",
      options.sensor, options.cells, options.min_diameter_px,
      options.level > 0 ? fmt::format("{:.2f}", options.level)
                        : "the level with the largest expected IoU of each completion",
      options.views));
  for (const std::string& set : benchmark.skipped_sets) {
    page.Note(fmt::format("Note: {}.", SkippedText(set)));
  }
  for (const MeasureColumn& measure : kMeasures) {
    page.Heading(measure.heading);
    page.Paragraph(std::string(measure.help) + ".");
    for (const bool is_occluded : {false, true}) {
      page.Subheading(ConditionName(is_occluded));
      page.Table(MeasureTable(benchmark, measure, is_occluded));
    }
  }
  if (benchmark.methods.size() > 1) {
    page.Heading(benchmark.methods.front() + " against the other methods");
    page.Paragraph("Difference of the IoU on the same views, with its interval over shapes.");
    for (const bool is_occluded : {false, true}) {
      page.Subheading(ConditionName(is_occluded));
      page.Table(DifferenceTable(benchmark, is_occluded));
    }
  }
  page.Heading("Calibration of " + benchmark.methods.front());
  page.Paragraph(
      "Share of the cells inside the true shape, by their probability, with its interval over "
      "shapes.");
  page.Table(CalibrationTable(benchmark));
  page.Heading("Seconds");
  TableCells seconds{{"method", "median seconds of a completion"}};
  for (const std::string& method : benchmark.methods) {
    if (method == kTrueShapes) continue;
    seconds.push_back({method, SecondsText(SecondsOf(benchmark, method))});
  }
  page.Table(seconds);
  page.Heading("Gallery of " + benchmark.methods.front());
  for (const auto& [set, tiles] : benchmark.gallery) {
    const Image<Rgb8> sheet = DrawCompletions(tiles, static_cast<float>(options.level));
    if (sheet.empty()) continue;
    page.Subheading(set);
    const std::string file = "gallery_" + set + ".png";
    WritePng(folder / file, sheet);
    page.WidePicture(
        file,
        "depth with the segment (occluders are orange), the completion from the camera "
        "and from its side, the truth from the camera and from its side");
  }
}

}  // namespace pickbed::eval
