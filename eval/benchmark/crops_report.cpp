#include "eval/benchmark/crops_report.h"

#include <fmt/format.h>

#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

// A rate and its interval as CSV columns: share,low,high.
std::string RateCsv(const std::vector<Cluster>& clusters) {
  constexpr int kDecimals = 4;
  return fmt::format(",{:.4f},{}", RateOf(clusters),
                     IntervalCells(ClusterInterval(clusters), kDecimals));
}

std::string NameOf(const CropCell& cell) {
  return fmt::format("{}, {}", cell.method, CropStageName(cell.stage));
}

// Difference between two rates over the same test views, first minus second.
struct Difference {
  double by = 0;
  Interval ci95;
};

Difference DifferenceOf(const std::vector<Cluster>& of_method,
                        const std::vector<Cluster>& of_other) {
  return {RateOf(of_method) - RateOf(of_other), PairedInterval(of_other, of_method)};
}

constexpr int kTenDegrees = 1;  // index in kCropAngles_deg

}  // namespace

std::string CropTableText(const CropBenchmark& benchmark) {
  std::string text;
  for (const int condition : CropConditionsOf(benchmark)) {
    text += fmt::format("{}\n  {:<30}{:>8}{:>8}{:>8}{:>8}{:>8}{:>10}{:>9}\n",
                        CropConditionTable()[condition].name, "", "object %", "<5 deg", "<10",
                        "<20", "<40", "median", ">15 %");
    for (CropCell cell : CropRows(benchmark)) {
      cell.condition = condition;
      const CropStatistics f = StatisticsOf(benchmark, cell);
      text += fmt::format("  {:<30}{:>8}", NameOf(cell), PercentNumber(RateOf(f.object_right)));
      for (const std::vector<Cluster>& within : f.within) {
        text += fmt::format("{:>8}", PercentNumber(RateOf(within)));
      }
      text += fmt::format("{:>10.2f}{:>9}\n", MedianOf(f.angles_deg),
                          PercentNumber(RateOf(f.over_15_deg)));
    }
  }
  return text;
}

ResultColumns CropTableColumns() {
  ResultColumns columns{
      {"method", "name of the crop method"},
      {"stage", "nearest template, with ICP, or only ICP"},
      {"condition", "name of the test condition"},
      {"object", "name of the object, or all"},
      {"views", "number of test views"},
  };
  const auto add_rate = [&](const std::string& name, const std::string& help) {
    AddColumns({{name, help, "0..1"},
                {name + "_low", "lower end of its 95 % interval", "0..1"},
                {name + "_high", "upper end of its 95 % interval", "0..1"}},
               columns);
  };
  add_rate("object_right", "share of views with the right object");
  for (const double angle_deg : kCropAngles_deg) {
    add_rate(fmt::format("within_{:.0f}", angle_deg),
             fmt::format("share of views with a rotation error up to {:.0f} degrees", angle_deg));
  }
  add_rate("over_15", "share of views with a rotation error over 15 degrees or a wrong object");
  AddColumns({{"median_deg", "median rotation error; infinite for a wrong object"},
              {"median_deg_low", "lower end of its 95 % interval", "deg"},
              {"median_deg_high", "upper end of its 95 % interval", "deg"}},
             columns);
  return columns;
}

ResultColumns CropViewsColumns() {
  return {
      {"method", "name of the crop method"},
      {"stage", "nearest template, with ICP, or only ICP"},
      {"condition", "name of the test condition"},
      {"object", "name of the object in the view"},
      {"view", "number of the test view"},
      {"found_object", "name of the object in the answer; empty = no answer"},
      {"angle_deg", "rotation error, minimum over the symmetries; infinite for a wrong object"},
      {"occluded", "occluded fraction of the object", "0..1"},
  };
}

ResultColumns CropTimingsColumns() {
  return {
      {"method", "name of the crop method"},
      {"stage", "nearest template, with ICP, only ICP, or made (training and templates)"},
      {"condition", "name of the test condition"},
      {"seconds_a_crop", "mean time per crop; of the stage made: total time", "s"},
  };
}

ResultColumns CropDifferencesColumns() {
  return {
      {"method", "name of the first method"},
      {"other", "name of the second method"},
      {"stage", "nearest template, with ICP, or only ICP"},
      {"condition", "name of the test condition"},
      {"statistic", fmt::format("object_right or within_10, see {}", kCropsFile)},
      {"difference", "rate of the first method minus rate of the second"},
      {"low", "lower end of the 95 % interval, paired over views"},
      {"high", "upper end of the 95 % interval, paired over views"},
  };
}

std::string CropTableCsv(const CropBenchmark& benchmark, const ObjectSet& objects) {
  std::string csv = HeaderLine(CropTableColumns());
  for (CropCell cell : CropRows(benchmark)) {
    for (const int condition : CropConditionsOf(benchmark)) {
      for (ObjectId object = kAnyObject; object < static_cast<int>(objects.size()); ++object) {
        cell.condition = condition;
        cell.object = object < 0 ? std::nullopt : std::optional(object);
        const CropStatistics f = StatisticsOf(benchmark, cell);
        if (f.tests() == 0) continue;
        csv += fmt::format("{},{},{},{},{}", cell.method, CropStageName(cell.stage),
                           CropConditionTable()[condition].name,
                           object < 0 ? "all" : objects[object]->name, f.tests());
        csv += RateCsv(f.object_right);
        for (const std::vector<Cluster>& within : f.within) csv += RateCsv(within);
        constexpr int kDecimals = 3;
        csv += RateCsv(f.over_15_deg) +
               fmt::format(",{:.3f},{}\n", MedianOf(f.angles_deg),
                           IntervalCells(MedianInterval(f.angles_deg), kDecimals));
      }
    }
  }
  return csv;
}

std::string CropViewsCsv(const CropBenchmark& benchmark, const ObjectSet& objects) {
  std::string csv = HeaderLine(CropViewsColumns());
  for (const CropRecord& r : benchmark.records) {
    csv += fmt::format("{},{},{},{},{},{},{:.4f},{:.4f}\n", r.method, CropStageName(r.stage),
                       CropConditionTable()[r.condition].name, objects[r.object]->name, r.test,
                       r.found_object < 0 ? "" : objects[r.found_object]->name,
                       Degrees(r.angle_rad), r.occluded);
  }
  return csv;
}

std::string CropTimingsCsv(const CropBenchmark& benchmark) {
  std::string csv = HeaderLine(CropTimingsColumns());
  for (CropCell cell : CropRows(benchmark)) {
    for (const int condition : CropConditionsOf(benchmark)) {
      cell.condition = condition;
      csv +=
          fmt::format("{},{},{},{:.6f}\n", cell.method, CropStageName(cell.stage),
                      CropConditionTable()[condition].name, StatisticsOf(benchmark, cell).seconds);
    }
  }
  for (const CropBenchmark::Training& training : benchmark.training) {
    csv += fmt::format("{},made,,{:.1f}\n", training.method, training.seconds);
  }
  return csv;
}

std::string CropDifferencesCsv(const CropBenchmark& benchmark) {
  std::string csv = HeaderLine(CropDifferencesColumns());
  const std::vector<CropCell> rows = CropRows(benchmark);
  for (size_t first = 0; first < rows.size(); ++first) {
    for (size_t second = first + 1; second < rows.size(); ++second) {
      CropCell cell = rows[first], other = rows[second];
      if (cell.stage != other.stage) continue;
      for (const int condition : CropConditionsOf(benchmark)) {
        cell.condition = other.condition = condition;
        const CropStatistics ours = StatisticsOf(benchmark, cell),
                             theirs = StatisticsOf(benchmark, other);
        const auto line = [&](const char* statistic, const Difference& d) {
          constexpr int kDecimals = 4;
          csv += fmt::format("{},{},{},{},{},{:.4f},{}\n", cell.method, other.method,
                             CropStageName(cell.stage), CropConditionTable()[condition].name,
                             statistic, d.by, IntervalCells(d.ci95, kDecimals));
        };
        line("object_right", DifferenceOf(ours.object_right, theirs.object_right));
        line("within_10", DifferenceOf(ours.within[kTenDegrees], theirs.within[kTenDegrees]));
      }
    }
  }
  return csv;
}

}  // namespace pickbed::eval
