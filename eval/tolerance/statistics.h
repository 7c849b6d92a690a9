#pragma once

// Statistics of a tolerance study: success by error along each axis, the tolerated region, maps of
// pairs, the fitted model, and how well each score predicts the outcomes.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/metrics/pose_errors.h"
#include "eval/stats/roc.h"
#include "eval/stats/statistics.h"
#include "eval/tolerance/samples.h"

namespace pickbed::eval {

// Success at one error level.
struct LevelShare {
  double offset = 0;  // in the unit of the axis
  int successes = 0, samples = 0;
  // By the index of the first identical grasp: a grasp that was drawn twice gives its outcome
  // twice.
  std::map<int, Cluster> of_grasp;
  double share() const { return samples > 0 ? double(successes) / samples : 0; }
  Interval band() const;  // 95 % interval; grasps are the units
};
// "[8.1, 18.4]", or "(too few grasps)".
std::string BandText(const LevelShare& level);

// Tolerated errors in the unit of the axis. If the region extends beyond the map, the end is the
// end of the map and is marked `open`.
struct ToleranceRegion {
  double low = 0, high = 0;
  bool low_open = false, high_open = false;
};

// Success by error along one axis.
struct AxisCurve {
  int axis = 0;
  std::string help;                // meaning of the axis for this gripper
  std::vector<LevelShare> levels;  // by offset
  ToleranceRegion region;
};

// Success by errors along two axes.
struct PairMap {
  std::array<int, 2> axis{};
  std::vector<double> offsets_a, offsets_b;
  std::vector<LevelShare> cells;  // rows over b, columns over a
};

// Score of a pose, and its prediction quality.
struct Predictor {
  std::string name, help;
  AucResult auc;
  AucDifference to_first;  // relative to the first predictor
};

// All statistics of a tolerance study.
struct ToleranceStatistics {
  std::string object, gripper;
  LevelShare at_truth;  // without an error
  std::vector<AxisCurve> axes;
  std::vector<PairMap> pairs;
  ToleranceModel model;
  std::vector<Predictor> predictors;  // on the test picks; the risk of the model is first
  int test_picks = 0;
  double brier = 0;  // mean squared difference between probability and outcome of the test picks
};

// Largest interval of errors around 0 in which the share is at least `minimum`, with linear
// interpolation between levels. Empty (0, 0) if the share at 0 is lower or there is no success.
ToleranceRegion RegionOf(const std::vector<LevelShare>& levels, double minimum);

// Computes the statistics. `outcomes`: one per sample of the study, complete.
ToleranceStatistics StatisticsOf(const ToleranceStudy& study,
                                 const std::vector<SampleOutcome>& outcomes);

// Outcome of a pick with pose error `X_OE`, from any source.
struct JudgedPick {
  Pose X_OE = Pose::Identity();
  bool success = false;
  int cluster = 0;                          // picks of one bin are not independent
  std::optional<Pose> X_OG = std::nullopt;  // of the grasp, if known
};
// Name of the risk of the model for the executed grasp, instead of the mean over all grasps.
inline constexpr char kGraspRisk[] = "grasp_risk";

// Picks of one object, with the data for its scores.
struct JudgedObject {
  const ToleranceModel& model;
  const ObjectModel& object;
  std::vector<JudgedPick> picks;
};

// Evaluates scores over the picks of all objects together: the risk of the models, every metric
// that needs no camera and, if all grasps are known, the risk for the executed grasp. The risk of
// the models is first, then the best. Intervals are DeLong's, or bootstrap intervals over clusters
// if a cluster has several picks.
std::vector<Predictor> JudgePredictors(const std::vector<JudgedObject>& objects);

}  // namespace pickbed::eval
