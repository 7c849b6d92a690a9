#pragma once

// Trials: a bin is dropped, then attempts follow until it is empty or the policy ends the trial
// (scenes/scenario/policy.h). An occlusion scenario has occlusion trials instead: one target,
// captured and picked once in each band of its visible fraction (scenes/scenario/occlusion_spec.h).

#include "eval/trial/trial_records.h"
#include "eval/trial/trial_setup.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

class TrialObserver;

// Runs the trial of one bin. `observer`, if not null, is notified after each stage of each attempt.
TrialResult RunTrial(TrialSetup& setup, BinIndex bin_index, TrialObserver* observer = nullptr);

// Runs an occlusion trial. Each attempt starts from the scene of its band and does not depend on
// the attempt before. It counts as one dropped and requested instance that is picked or lost.
TrialResult RunOcclusionTrial(TrialSetup& setup, BinIndex bin_index,
                              TrialObserver* observer = nullptr);

// Runs the kind of trial that the scenario requires, with one setup for all trials.
class TrialRunner {
 public:
  using Progress = TrialSetup::Progress;

  // Throws as the constructor of TrialSetup.
  TrialRunner(const ScenarioSpec& spec, const ObjectSet& objects, const Progress& on_progress = {},
              const TrialOptions& options = {})
      : setup_(spec, objects, on_progress, options) {}

  TrialResult Run(BinIndex bin_index, TrialObserver* observer = nullptr) {
    return setup_.spec.occlusion.enabled ? RunOcclusionTrial(setup_, bin_index, observer)
                                         : RunTrial(setup_, bin_index, observer);
  }

 private:
  TrialSetup setup_;
};

}  // namespace pickbed::eval
