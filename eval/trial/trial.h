#pragma once

// Trials: a bin is dropped, then attempts follow until it is empty or the policy ends the trial
// (scenes/scenario/policy.h). An occlusion scenario has occlusion trials instead: one target,
// captured and picked once in each band of its visible fraction (scenes/scenario/occlusion_spec.h).

#include <memory>
#include <optional>

#include "eval/trial/trial_records.h"
#include "eval/trial/trial_setup.h"
#include "scenes/base/ids.h"
#include "scenes/scenario/policy.h"

namespace pickbed::eval {

class LiveAttempt;
class TrialObserver;
struct LiveTrial;

// A trial of one bin, attempt by attempt. The caller decides which grasps are executed.
class PickingTrial {
 public:
  // Drops the bin. `setup` and `observer` must outlive this object. `observer` may be null.
  PickingTrial(TrialSetup& setup, BinIndex bin_index, TrialObserver* observer = nullptr);
  ~PickingTrial();
  PickingTrial(const PickingTrial&) = delete;
  PickingTrial& operator=(const PickingTrial&) = delete;

  // Returns whether the bin is empty or the policy ended the trial.
  bool HasEnded() const;
  // Returns whether only the maximum number of attempts ended the trial.
  bool HasReachedLimit() const;
  // Returns the attempt under way, and begins it if needed. After a successful pick, it continues
  // with the last image while a further pick cannot be disturbed by the earlier ones. Else it
  // captures a new image. Throws std::logic_error if the trial has ended.
  LiveAttempt& Attempt();
  // Executes a grasp in the attempt under way, see LiveAttempt::Execute(), and ends the attempt.
  const AttemptRecord& Execute(const std::optional<Grasp>& grasp);

  const Scene& scene() const;  // now
  BinIndex bin_index() const;
  int attempts() const { return state_.attempts; }  // that have ended
  // Returns the result of a trial that has ended. Call it once.
  TrialResult TakeResult();

 private:
  TrialSetup& setup_;
  const PolicyRow& policy_;
  const int max_attempts_;  // 0 = no limit
  std::unique_ptr<LiveTrial> trial_;
  std::unique_ptr<LiveAttempt> attempt_;  // null: not begun
  TrialResult result_;
  PolicyState state_;
  int stirs_ = 0;
  int without_grasp_ = 0;  // attempts in a row
  int failed_ = 0;         // attempts in a row since the last success or stir
  bool may_stir_ = false;  // in the attempt under way, or later
};

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
