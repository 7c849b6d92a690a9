#pragma once

// What one reads off a row of a comparison.

#include <optional>
#include <vector>

#include "eval/comparison.h"
#include "eval/error_median.h"
#include "eval/summary.h"

namespace pickbed {

struct ReliabilityBin {
  double score_sum = 0;
  int count = 0, right = 0;
};

struct ComparisonFigures {
  int bins = 0,
      top_right = 0;  // bins whose highest-ranked pose is right; one without a pose is not
  int instances = 0, recalled = 0;  // of those at least 10 % visible
  std::vector<RecallBand> bands;    // 10-30, 30-50, 50-70, 70-90, 90-100 % visible
  int poses = 0, right = 0;         // reported, and right, one for each instance
  int identity_right = 0;           // the nearest part is of the kind that was named
  double recall_at_95 = 0;          // largest recall with a threshold of precision >= 0.95
  // Of poses that stand on an instance (MSSD < 0.5 diameter).
  ErrorMedian median_rotation_deg, median_mssd_diameters;
  double share_over_15_deg = 0;
  double calibration_error = 0;  // ECE, ten bins of equal width
  std::vector<ReliabilityBin> reliability;
  // Mean chance that a pick on the highest-ranked pose succeeds, over the bins where its part has a
  // tolerance map; 0 counts for a bin without a pose. Nothing without maps.
  std::optional<double> top_pick_chance;
  double seconds = 0;   // of an image, mean
  StageSeconds stages;  // the same by stage

  double recall() const { return instances > 0 ? static_cast<double>(recalled) / instances : 0; }
  double precision() const { return poses > 0 ? static_cast<double>(right) / poses : 0; }
};

// Of one kind of part, or of all. Times and top-ranked poses are always of whole images.
ComparisonFigures FiguresOf(const ComparedRow& row, std::optional<int> object = std::nullopt);

}  // namespace pickbed
