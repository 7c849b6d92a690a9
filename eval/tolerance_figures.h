#pragma once

// What the outcomes of a tolerance study say: success against the error along each axis, the region
// that still succeeds, maps of pairs, the fitted model, and how well each score foretells outcomes.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/metrics.h"
#include "eval/roc.h"
#include "eval/statistics.h"
#include "eval/tolerance_tries.h"

namespace pickbed {

struct LevelShare {
  double offset = 0;  // in the axis's unit
  int successes = 0, tries = 0;
  // By the first grasp that is the same: one that was drawn twice tells its outcome twice.
  std::map<int, Cluster> of_grasp;
  double share() const { return tries > 0 ? double(successes) / tries : 0; }
  Interval band() const;  // 95 %, grasps are the units
};

// Errors in the axis's unit; an end that the map does not reach is where the map ends, `open`.
struct ToleranceRegion {
  double low = 0, high = 0;
  bool low_open = false, high_open = false;
};

struct AxisCurve {
  int axis = 0;
  std::string help;                // what the axis is with this gripper
  std::vector<LevelShare> levels;  // by offset
  ToleranceRegion region;
};

struct PairMap {
  std::array<int, 2> axis{};
  std::vector<double> offsets_a, offsets_b;
  std::vector<LevelShare> cells;  // row by row of b, a within
};

// A score of a pose and how well it foretells outcomes.
struct Predictor {
  std::string name, help;
  AucResult auc;
  AucDifference to_first;  // less the first predictor's
};

struct ToleranceFigures {
  std::string object, gripper;
  LevelShare at_truth;  // without an error
  std::vector<AxisCurve> axes;
  std::vector<PairMap> pairs;
  ToleranceModel model;
  std::vector<Predictor> predictors;  // of the test's picks; the model's risk first
  int test_picks = 0;
  double brier = 0;  // mean squared difference of probability and outcome of the test's picks
};

// The longest run of errors about 0 whose share stays at or above `least`, straight lines between
// the levels. Empty (0, 0) when the share at 0 is below.
ToleranceRegion RegionOf(const std::vector<LevelShare>& levels, double least);

// `outcomes` by try of the study, all of them.
ToleranceFigures FiguresOf(const ToleranceStudy& study, const std::vector<TryOutcome>& outcomes);

// A pick whose pose was off by `X_OtrueObelieved`, from wherever it was executed.
struct JudgedPick {
  Pose X_OtrueObelieved = Pose::Identity();
  bool success = false;
  int cluster = 0;                          // picks of one bin are not independent
  std::optional<Pose> X_OG = std::nullopt;  // of the grasp, where it is known
};
// The name of the model's risk for the grasp that was executed, instead of over all grasps.
inline constexpr char kGraspRisk[] = "grasp_risk";

// Picks of one part, with what scores them.
struct JudgedPart {
  const ToleranceModel& model;
  const ObjectModel& part;
  std::vector<JudgedPick> picks;
};

// The models' risk, every metric of the table that needs no camera and, where all grasps are known,
// the risk of the very grasp, over the picks of all parts together; best first after the models'.
// Intervals are DeLong's, or of a bootstrap over clusters when there are several picks in some.
std::vector<Predictor> JudgePredictors(const std::vector<JudgedPart>& parts);

}  // namespace pickbed
