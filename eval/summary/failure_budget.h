#pragma once

// Failure budgets: counts of picks and of failures by reason. The entries of a budget sum exactly
// to its total. There are two budgets:
//
// - Attempts: every attempt on a bin that holds wanted instances requests one pick. It succeeds or
//   fails for one reason; an attempt that finds no grasp is a failure.
// - Instances: every wanted instance that was dropped is picked, failed for one reason, or not
//   requested (eval/trial/instance_outcomes.h). Requested are one instance per attempt, and
//   instances that a pick removed from the bin as a side effect. If the policy limits the number of
//   attempts, these are only a few of all instances.
//
// Shares and rates are relative to what was requested: all attempts, or the requested instances.

#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"
#include "scenes/scenario/failure_reason.h"

namespace pickbed::eval {

// Counts of one budget.
struct FailureBudget {
  int total = 0;
  int picked = 0;
  int not_asked = 0;                            // only in a budget of instances
  std::array<int, kFailureReasons> failures{};  // by FailureReason; [kNone] = 0

  int operator[](FailureReason failure) const { return failures.at(static_cast<size_t>(failure)); }
  int asked() const { return total - not_asked; }  // picked + failures
  // Returns the number of failures attributed to this stage.
  int Of(Stage stage) const;
};

// Computes the budget of the attempts. Both budgets throw std::logic_error if the entries do not
// sum to the number of attempts or of dropped instances. They also throw it if the picks differ
// from the instances that the trials count as cleared.
FailureBudget BudgetOfAttempts(std::span<const TrialResult> trials);
// Computes the budget of the dropped instances.
FailureBudget BudgetOfInstances(std::span<const TrialResult> trials);

// Returns whether the outcomes of a trial add up to its dropped instances, and the picked ones to
// the cleared instances, as BudgetOfInstances() requires. An edited store may have others.
bool OutcomesAddUp(const TrialResult& trial);

// Throws std::logic_error if a stage before planning has failures. With ground truth substituted
// for all of perception, only plan, approach, grasp and simulation (physics errors) can fail.
void RequireGraspFailuresOnly(const FailureBudget& budget);

// Returns picked and requested attempts per trial; input of the intervals.
std::vector<Cluster> AttemptsByTrial(std::span<const TrialResult> trials);
// Returns picked and requested instances per trial.
std::vector<Cluster> InstancesByTrial(std::span<const TrialResult> trials);

// A budget with the 95 % intervals of its shares. Bins are the units of the intervals, because
// failures in one bin are not independent (eval/stats/statistics.h).
struct BudgetShares {
  FailureBudget budget;
  Interval picked;
  std::array<Interval, std::tuple_size_v<decltype(FailureBudget::failures)>>
      failures;  // by FailureReason

  const Interval& operator[](FailureReason failure) const {
    return failures.at(static_cast<size_t>(failure));
  }
};
// Computes the budget of the attempts and its intervals. Throws like BudgetOfAttempts().
BudgetShares SharesOfAttempts(std::span<const TrialResult> trials);
// Computes the budget of the instances and its intervals.
BudgetShares SharesOfInstances(std::span<const TrialResult> trials);

}  // namespace pickbed::eval
