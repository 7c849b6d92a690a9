#pragma once

// What one reads off the records of the crop table.

#include <optional>
#include <string>
#include <vector>

#include "eval/crop_benchmark.h"

namespace pickbed {

// Angles within which a pose counts, degrees.
inline constexpr double kCropAngles_deg[] = {5, 10, 20, 40};

// Whose records are counted together.
struct CropCell {
  std::string method;
  CropStage stage = CropStage::kNearest;
  int condition = 0;          // row of CropConditionTable()
  std::optional<int> object;  // none = all parts
};

// Of one cell. A wrong part has an infinite angle: it is within none, over 15 degrees, and counts
// in the median.
struct CropFigures {
  std::vector<Cluster> part_right;           // by test view, as all below
  std::vector<std::vector<Cluster>> within;  // by kCropAngles_deg
  std::vector<Cluster> over_15_deg;
  ValueClusters angles_deg;
  double seconds = 0;  // a crop, mean
  int tests() const { return static_cast<int>(part_right.size()); }
};

CropFigures FiguresOf(const CropBenchmark& benchmark, const CropCell& cell);

// Methods with their stages, in order of appearance.
std::vector<CropCell> CropRows(const CropBenchmark& benchmark);
// Conditions that were measured, in the table's order.
std::vector<int> CropConditionsOf(const CropBenchmark& benchmark);

}  // namespace pickbed
