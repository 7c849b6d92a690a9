#pragma once

// Names of the stages of a trial in its timings.

#include <algorithm>
#include <string>
#include <string_view>

#include "eval/trial/trial_records.h"
#include "scenes/base/finite_counts.h"

namespace pickbed::eval {

inline constexpr std::string_view kTimedStages[] = {"drop", "capture", "estimate", "score",
                                                    "plan", "try",     "execute"};
// Begin of a stage of an estimator, whose name the estimator chooses.
inline constexpr std::string_view kEstimatorStage = "estimate/";

// Returns the present name of a stage.
inline std::string CurrentStage(const std::string& stage) {
  for (const RenamedStage& renamed : kRenamedStages) {
    if (renamed.was == stage) return std::string(renamed.is);
  }
  return stage;
}

// Returns whether a trial can have this stage: one of the trial itself, one of an estimator, or a
// counter of values that are not finite.
inline bool IsTimedStage(const std::string& stage) {
  const auto is_counter = [&](const char* name) {
    return stage == kNotFinitePrefix + std::string(name);
  };
  return std::find(std::begin(kTimedStages), std::end(kTimedStages), stage) !=
             std::end(kTimedStages) ||
         (stage.starts_with(kEstimatorStage) && stage.size() > kEstimatorStage.size()) ||
         std::any_of(kFiniteBoundaryNames.begin(), kFiniteBoundaryNames.end(), is_counter);
}

}  // namespace pickbed::eval
