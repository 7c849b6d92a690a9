#pragma once

// Statistics computed from the records of the crop benchmark.

#include <optional>
#include <string>
#include <vector>

#include "eval/benchmark/crops.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Thresholds on the rotation error, in degrees.
inline constexpr double kCropAngles_deg[] = {5, 10, 20, 40};

// Selects the records that are counted together.
struct CropCell {
  std::string method;
  CropStage stage = CropStage::kNearest;
  int condition = 0;               // row of CropConditionTable()
  std::optional<ObjectId> object;  // nullopt = all objects
};

// Statistics of one cell. A wrong object has an infinite angle: it is within no threshold, it is
// over 15 degrees, and it counts in the median.
struct CropStatistics {
  std::vector<Cluster> object_right;         // one per test view, as all vectors below
  std::vector<std::vector<Cluster>> within;  // [index in kCropAngles_deg][test view]
  std::vector<Cluster> over_15_deg;
  ValueClusters angles_deg;
  double seconds = 0;  // mean time per crop
  int tests() const { return static_cast<int>(object_right.size()); }
};

// Computes the statistics of the records of one cell.
CropStatistics StatisticsOf(const CropBenchmark& benchmark, const CropCell& cell);

// Returns each pair of method and stage once, in order of first appearance.
std::vector<CropCell> CropRows(const CropBenchmark& benchmark);
// Returns the conditions that were measured, in the order of CropConditionTable().
std::vector<int> CropConditionsOf(const CropBenchmark& benchmark);

}  // namespace pickbed::eval
