#pragma once

// Prediction of the picks of a run from their pose errors, by the tolerance models of its objects.
// MSSD, ADD and ADI are evaluated as well. Only picks with a pose matched to an instance of its
// object are counted, because the others have no pose error.

#include <span>
#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/stats/statistics.h"
#include "eval/tolerance/maps.h"
#include "eval/tolerance/statistics.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Forecast for the picks of one object, or of all objects with a model.
struct PickForecast {
  std::string object;
  int bins = 0;  // bins with such a pick
  int picks = 0, successes = 0;
  // Number of successes predicted by the model (sum of the probabilities): as mean over all its
  // grasps, and for the executed grasp.
  double expected = 0, expected_with_grasp = 0;
  Interval rate_ci95;  // of successes / picks; bins are the units
  std::vector<Predictor> predictors;
};

// Executed picks of an object whose pose is matched to an instance of it; clusters are the trials.
std::vector<JudgedPick> JudgedPicksOf(std::span<const TrialResult> trials, ObjectId object);

// One forecast per object with a model and picks, followed by one for all if there are several.
std::vector<PickForecast> ForecastsOf(std::span<const TrialResult> trials, const ObjectSet& objects,
                                      const ToleranceMaps& maps);

std::string ForecastText(const std::vector<PickForecast>& forecasts);  // for the console
std::string ForecastJson(const std::vector<PickForecast>& forecasts);  // JSON array
// One CSV line per hypothesis of an object with a model, with its success probability p_pick.
std::string PickChancesCsv(std::span<const TrialResult> trials, const ObjectSet& objects,
                           const ToleranceMaps& maps);
// Returns the columns of PickChancesCsv().
ResultColumns PickChancesColumns();
// Returns the keys of an entry of ForecastJson().
ResultColumns ForecastKeys();

}  // namespace pickbed::eval
