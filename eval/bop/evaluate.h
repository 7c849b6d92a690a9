#pragma once

// Scores of pose estimates on a BOP data set, by the rules that eval/bop/scores.h states. Errors:
// VSD (tolerances 0.05 to 0.5 diameters, thresholds 0.05 to 0.5), MSSD (thresholds 0.05 to 0.5
// diameters) and MSPD (thresholds 5 to 50 px of an image 640 px wide). Symmetries are those of
// models_info.json, errors are taken over all vertices of models_eval (else models).

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/bop/evaluator.h"
#include "eval/bop/results_csv.h"
#include "eval/bop/vsd.h"

namespace pickbed::bop {

// Throws InputError for a broken data set, a split without scenes, targets without truth, and
// estimates of an object that models_info.json does not have.
Scores Evaluate(const std::filesystem::path& root, const std::string& split,
                const std::vector<Estimate>& estimates, const VsdOptions& options = {},
                const std::function<void(const std::string& scene)>& on_scene = {});

}  // namespace pickbed::bop
