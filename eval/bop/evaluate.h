#pragma once

// Scores of pose estimates on a BOP data set, by the rules that eval/bop/scores.h states. Errors:
// VSD (tolerances 0.05 to 0.5 diameters, thresholds 0.05 to 0.5), MSSD (thresholds 0.05 to 0.5
// diameters) and MSPD (thresholds 5 to 50 px of an image 640 px wide). Symmetries are those of
// models_info.json, errors are taken over all vertices of models_eval (else models).

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "eval/bop/evaluator.h"
#include "eval/bop/results_csv.h"
#include "eval/bop/vsd.h"
#include "grasp/tolerance.h"

namespace pickbed::bop {

// A tolerance model of an object and the file that it was read from.
struct NamedTolerance {
  std::filesystem::path file;
  ToleranceModel model;
};
using TolerancesById = std::map<int, NamedTolerance>;
// Each text is ID=PLACE: an obj_id, and a model.yaml of `pickbed tolerance` or its folder. Throws
// InputError for what is neither and for an object that comes twice.
TolerancesById ReadTolerances(const std::vector<std::string>& texts);

// Throws InputError for a broken data set, a split without scenes, targets without truth, and
// estimates or tolerance models of an object that models_info.json does not have or, these, of
// another mesh.
Scores Evaluate(const std::filesystem::path& root, const std::string& split,
                const std::vector<Estimate>& estimates, const VsdOptions& options = {},
                const TolerancesById& tolerances = {},
                const std::function<void(const std::string& scene)>& on_scene = {});

}  // namespace pickbed::bop
