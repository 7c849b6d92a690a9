#pragma once

// Estimators on the same bins: every row sees the same images, with the same random numbers, and is
// scored against the same truth.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/bop/evaluator.h"
#include "eval/matching.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

// "ppf", "descriptor:hard" or "kehl:hard=kehl.pt": the name of an estimator and, where it has some,
// a mode and a model.
struct ComparedEstimator {
  std::string label;
  EstimatorSpec spec;
};
// The scenario's estimator with name, mode and model of each label; without a model it is that of
// the scenario where the name is the scenario's, else the shipped one. Throws InputError for
// unknown names, for a label that comes twice, and for '=' without a model.
std::vector<ComparedEstimator> ParseEstimators(const std::vector<std::string>& labels,
                                               const EstimatorSpec& base);

struct ComparedLook {
  int trial = 0;
  LookScore score;
  StageSeconds seconds;  // see EstimatorRunner
  // By hypothesis, see eval/tolerance_maps.h; empty without maps.
  std::vector<std::optional<double>> pick_chances = {};
};

struct ComparedRow {
  std::string label;
  std::vector<ComparedLook> looks;  // by trial
  bop::Scores bop;                  // AR and AP of all bins; object ids are index + 1
  double setup_s = 0;               // to load, with code books where they were not in the cache
  // That it took at most, over what the process held before; of looks after the first, not what it
  // took of memory that other rows had freed.
  double peak_memory_mib = 0;
};

struct ComparisonJob {
  ScenarioSpec spec;
  ObjectSet objects;
  std::vector<ComparedEstimator> estimators;
  std::filesystem::path pictures;  // gets trial_0000/LABEL/ of the first bins; empty = none
  int pictured_bins = 0;
  int threads = 1;  // at most; results are the same for any number
  std::function<void(std::string_view what, int done, int total)> on_progress;  // may be empty
  std::function<bool()> stop;                                                   // may be empty
};

// Bins are filled one after the other and each row looks at each. Stops after a bin when asked to,
// with what is done by then. Throws InputError, see VirtualCell and EstimatorRunner.
std::vector<ComparedRow> CompareEstimators(const ComparisonJob& job);

class ToleranceMaps;  // eval/tolerance_maps.h
// Fills the chances of every look.
void AddPickChances(const ToleranceMaps& maps, std::vector<ComparedRow>& rows);

}  // namespace pickbed
