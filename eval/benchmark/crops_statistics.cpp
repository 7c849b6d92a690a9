#include "eval/benchmark/crops_statistics.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "scenes/base/math.h"

namespace pickbed::eval {

CropStatistics StatisticsOf(const CropBenchmark& benchmark, const CropCell& cell) {
  constexpr double kOver_deg = 15;
  CropStatistics statistics;
  statistics.within.resize(std::size(kCropAngles_deg));
  for (const CropRecord& record : benchmark.records) {
    if (record.method != cell.method || record.stage != cell.stage ||
        record.condition != cell.condition || (cell.object && record.object != *cell.object)) {
      continue;
    }
    const double angle_deg = Degrees(record.angle_rad);
    statistics.object_right.push_back({record.found_object == record.object ? 1 : 0, 1});
    for (size_t i = 0; i < statistics.within.size(); ++i) {
      statistics.within[i].push_back({angle_deg <= kCropAngles_deg[i] ? 1 : 0, 1});
    }
    statistics.over_15_deg.push_back({angle_deg > kOver_deg ? 1 : 0, 1});
    statistics.angles_deg.push_back({angle_deg});
    statistics.seconds += record.seconds;
  }
  if (statistics.tests() > 0) statistics.seconds /= statistics.tests();
  return statistics;
}

std::vector<CropCell> CropRows(const CropBenchmark& benchmark) {
  std::vector<CropCell> rows;
  for (const CropRecord& record : benchmark.records) {
    const auto is_it = [&](const CropCell& row) {
      return row.method == record.method && row.stage == record.stage;
    };
    if (std::none_of(rows.begin(), rows.end(), is_it)) {
      rows.push_back({record.method, record.stage, 0, {}});
    }
  }
  return rows;
}

std::vector<int> CropConditionsOf(const CropBenchmark& benchmark) {
  std::set<int> conditions;
  for (const CropRecord& record : benchmark.records) conditions.insert(record.condition);
  return {conditions.begin(), conditions.end()};
}

}  // namespace pickbed::eval
