#pragma once

// Statistics of executed results: success of each method, failure reasons, paired differences, and
// how well the BOP errors of a pose predict the outcome of its pick. Scenes are the units of all
// intervals.

#include <map>
#include <string>
#include <vector>

#include "eval/compare/paired_tables.h"
#include "eval/execution/pick_rows.h"
#include "eval/stats/roc.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {

// A quantity that may predict the outcome of a pick.
struct OutcomePredictor {
  const char* name;   // key in execution.json
  const char* title;  // in tables and charts
  const char* help;
  double (*score)(const ExecutedPick& pick);  // higher = success expected
};
// Returns the predictors: the BOP errors (VSD, MSSD, MSPD, ADD, ADI), the score of the method, and
// the visible fraction.
const std::vector<OutcomePredictor>& OutcomePredictors();

// AUC of a predictor on the executed picks.
struct PredictorAuc {
  std::string name;
  AucResult auc;  // with a bootstrap interval over scenes
};

struct MethodStatistics {
  std::string method;
  ReportRate requested;  // successes among requested picks; one without a grasp is a failure
  ReportRate executed;   // successes among executed grasps
  std::map<FailureReason, ReportRate> failures;  // share of the requested picks, only nonzero ones
  std::vector<ReportRate> by_pick;               // successes of the first, second, ... picks
  std::vector<PredictorAuc> predictors;
};

struct ExecutionStatistics {
  int scenes = 0, images = 0, picks = 0;
  std::vector<MethodStatistics> methods;  // in the given order
  // AUC on the picks of all methods. The score of the method is left out, since scores of different
  // methods cannot be compared.
  std::vector<PredictorAuc> predictors;
  std::vector<ConfigurationComparison> paired;  // each method against the first one
};

// Computes the statistics. `methods`: names in the order of the tables.
ExecutionStatistics StatisticsOf(const std::vector<std::string>& methods,
                                 const std::vector<ExecutedPick>& picks);

}  // namespace pickbed::eval
