#pragma once

// Tables of a run as CSV. Their columns are in eval/summary/run_columns.h.

#include <string>
#include <vector>

#include "eval/store/results_store.h"
#include "eval/summary/cycle.h"
#include "eval/tolerance/maps.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

// Returns trials.csv: one line per trial. Crashed trials have empty cells.
std::string TrialsCsv(const std::vector<TrialResult>& trials,
                      const std::vector<CrashedTrial>& crashed = {});
// Returns attempts.csv: one line per attempt. p_pick is the success probability of the executed
// pose, averaged over the grasps of its tolerance model. p_grasp is the probability with the
// executed grasp. Both are empty without a model. `object_names` are the names of the dropped
// objects.
std::string AttemptsCsv(const std::vector<TrialResult>& trials,
                        const std::vector<std::string>& object_names,
                        const ToleranceMaps& maps = {});
// Returns instances.csv: one line per instance in view of each image.
std::string InstancesCsv(const std::vector<TrialResult>& trials,
                         const std::vector<std::string>& object_names);
// Returns instance_outcomes.csv: one line per wanted instance that was dropped.
std::string InstanceOutcomesCsv(const std::vector<TrialResult>& trials,
                                const std::vector<std::string>& object_names);
// Returns timings.csv: seconds by trial and stage. The last lines have the trial "all" and hold the
// cycle time per picked instance.
std::string TimingsCsv(const std::vector<TrialResult>& trials, const CycleTime& cycle = {});

}  // namespace pickbed::eval
