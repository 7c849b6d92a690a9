#pragma once

// Arguments that the forms of `pickbed estimate` share.

#include <string>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/estimate/estimator_comparison.h"
#include "eval/explain/explain.h"

namespace pickbed::eval {

// Returns the estimators named by --estimator, or the one of the settings. Throws InputError if no
// estimator uses the given model, because the comparison would not be the intended one.
std::vector<ComparedEstimator> NamedEstimators(const ScenarioRequest& arguments,
                                               const std::vector<std::string>& labels,
                                               const EstimatorSpec& base);

// Returns the estimator whose stages --explain shows. Throws InputError for several estimators and
// for one that reports no stages.
EstimatorSpec ExplainedEstimator(const ScenarioRequest& arguments,
                                 const std::vector<std::string>& labels, const EstimatorSpec& spec);

// Prints where the page with the stages is, or its pictures if there is no page.
void SayWhereExplained(const ExplanationPage& page);

// Returns the scenario settings that apply to existing images: estimator, refiner, roi and seed.
// `min_score` is the default of that setting. Throws InputError for an invalid setting.
ScenarioSpec ImageSettings(const ScenarioRequest& arguments, double min_score);

}  // namespace pickbed::eval
