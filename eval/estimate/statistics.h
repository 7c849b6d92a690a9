#pragma once

// Statistics of one estimator, computed from its row of a comparison.

#include <optional>
#include <vector>

#include "eval/estimate/estimator_comparison.h"
#include "eval/stats/median_error.h"
#include "eval/summary/run_summary.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Poses whose score is in one interval of the reliability diagram.
struct ReliabilityBin {
  double score_sum = 0;
  int count = 0, right = 0;
};

inline constexpr int kTopPoses = 5;  // of `top5_right`

struct ComparisonStatistics {
  int bins = 0,
      top_right = 0;  // bins whose highest-ranked pose is correct; a bin without a pose is not
  // Bins with at least kTopPoses instances. Those whose kTopPoses highest-ranked poses are correct
  // poses of different instances; a bin with fewer poses is not.
  int top5_bins = 0, top5_right = 0;
  int instances = 0, recalled = 0;  // instances at least 10 % visible
  std::vector<RecallBand> bands;    // 10-30, 30-50, 50-70, 70-90, 90-100 % visible
  int poses = 0, right = 0;         // reported poses; correct ones, at most one per instance
  int identity_right = 0;           // poses whose nearest instance is of the named object
  double recall_at_95 = 0;          // largest recall at a score threshold with precision >= 0.95
  // Over poses that match an instance roughly (MSSD < 0.5 diameter).
  ErrorMedian median_rotation_deg, median_mssd_diameters;
  double share_over_15_deg = 0;
  double calibration_error = 0;  // expected calibration error (ECE), ten bins of equal width
  std::vector<ReliabilityBin> reliability;
  // Mean success probability of a pick on the highest-ranked pose, over the bins where its object
  // has a tolerance model. A bin without a pose counts as 0. nullopt without tolerance models.
  std::optional<double> top_pick_chance;
  double seconds = 0;   // mean per image
  StageSeconds stages;  // mean per image, by stage

  double recall() const { return instances > 0 ? static_cast<double>(recalled) / instances : 0; }
  double precision() const { return poses > 0 ? static_cast<double>(right) / poses : 0; }
};

// Computes the statistics of one object, or of all. Times and highest-ranked poses always refer to
// whole images.
ComparisonStatistics StatisticsOf(const ComparedRow& row,
                                  std::optional<ObjectId> object = std::nullopt);

}  // namespace pickbed::eval
