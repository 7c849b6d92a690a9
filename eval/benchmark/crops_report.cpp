#include "eval/benchmark/crops_report.h"

#include <fmt/format.h>

#include <numbers>

namespace pickbed::eval {
namespace {

// A rate and its interval as CSV columns: share,low,high.
std::string RateCsv(const std::vector<Cluster>& clusters) {
  const Interval interval = ClusterInterval(clusters);
  return fmt::format(",{:.4f},{:.4f},{:.4f}", RateOf(clusters), interval.low, interval.high);
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
      text += fmt::format("  {:<30}{:>8}", NameOf(cell), PercentNumber(RateOf(f.part_right)));
      for (const std::vector<Cluster>& within : f.within) {
        text += fmt::format("{:>8}", PercentNumber(RateOf(within)));
      }
      text += fmt::format("{:>10.2f}{:>9}\n", MedianOf(f.angles_deg),
                          PercentNumber(RateOf(f.over_15_deg)));
    }
  }
  return text;
}

std::string CropTableCsv(const CropBenchmark& benchmark, const ObjectSet& objects) {
  std::string csv =
      "method,stage,condition,object,views,object_right,object_right_low,object_right_high";
  for (const double angle_deg : kCropAngles_deg) {
    csv += fmt::format(",within_{0:.0f},within_{0:.0f}_low,within_{0:.0f}_high", angle_deg);
  }
  csv += ",over_15,over_15_low,over_15_high,median_deg,median_deg_low,median_deg_high\n";
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
        csv += RateCsv(f.part_right);
        for (const std::vector<Cluster>& within : f.within) csv += RateCsv(within);
        const Interval median = MedianInterval(f.angles_deg);
        csv +=
            RateCsv(f.over_15_deg) +
            fmt::format(",{:.3f},{:.3f},{:.3f}\n", MedianOf(f.angles_deg), median.low, median.high);
      }
    }
  }
  return csv;
}

std::string CropViewsCsv(const CropBenchmark& benchmark, const ObjectSet& objects) {
  std::string csv = "method,stage,condition,object,view,found_object,angle_deg,occluded\n";
  for (const CropRecord& r : benchmark.records) {
    csv += fmt::format("{},{},{},{},{},{},{:.4f},{:.4f}\n", r.method, CropStageName(r.stage),
                       CropConditionTable()[r.condition].name, objects[r.object]->name, r.test,
                       r.found_object < 0 ? "" : objects[r.found_object]->name,
                       r.angle_rad * 180 / std::numbers::pi, r.occluded);
  }
  return csv;
}

std::string CropTimingsCsv(const CropBenchmark& benchmark) {
  std::string csv = "method,stage,condition,seconds_a_crop\n";
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
  std::string csv = "method,other,stage,condition,statistic,difference,low,high\n";
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
          csv += fmt::format("{},{},{},{},{},{:.4f},{:.4f},{:.4f}\n", cell.method, other.method,
                             CropStageName(cell.stage), CropConditionTable()[condition].name,
                             statistic, d.by, d.ci95.low, d.ci95.high);
        };
        line("object_right", DifferenceOf(ours.part_right, theirs.part_right));
        line("within_10", DifferenceOf(ours.within[kTenDegrees], theirs.within[kTenDegrees]));
      }
    }
  }
  return csv;
}

}  // namespace pickbed::eval
