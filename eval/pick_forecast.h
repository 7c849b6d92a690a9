#pragma once

// How well the picks of a run were foretold by its pose errors: by the chances of its parts'
// tolerance models, and beside them by MSSD, ADD and ADI. Only picks count whose pose stood on a
// part of its kind: of the others no error is known.

#include <span>
#include <string>
#include <vector>

#include "eval/statistics.h"
#include "eval/tolerance_figures.h"
#include "eval/tolerance_maps.h"

namespace pickbed {

// Of the picks of one part, or of all that have a model.
struct PickForecast {
  std::string part;
  int bins = 0;  // with such a pick
  int picks = 0, successes = 0;
  // Successes that the model foretells, the chances' sum: over all its grasps, and knowing which
  // was executed.
  double expected = 0, expected_with_grasp = 0;
  Interval rate_ci95;  // of successes / picks, over bins
  std::vector<Predictor> predictors;
};

// Executed picks of a part whose believed poses stood on one; clusters are the trials.
std::vector<JudgedPick> JudgedPicksOf(std::span<const TrialResult> trials, int object);

// A forecast for each part that has a model and picks, then of all when these are several.
std::vector<PickForecast> ForecastsOf(std::span<const TrialResult> trials, const ObjectSet& objects,
                                      const ToleranceMaps& maps);

std::string ForecastText(const std::vector<PickForecast>& forecasts);  // for people
std::string ForecastJson(const std::vector<PickForecast>& forecasts);  // an array
// A line a hypothesis of a part with a model, with its chance p_pick.
std::string PickChancesCsv(std::span<const TrialResult> trials, const ObjectSet& objects,
                           const ToleranceMaps& maps);

}  // namespace pickbed
