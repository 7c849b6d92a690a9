#include "eval/summary/failure_budget.h"

#include <fmt/format.h>

#include <numeric>
#include <stdexcept>

namespace pickbed::eval {
namespace {

void AddFailure(FailureReason failure, FailureBudget& budget) {
  ++budget.failures.at(static_cast<size_t>(failure));
}

void RequireSum(const char* what, int sum, int expected) {
  if (sum == expected) return;
  throw std::logic_error(
      fmt::format("the budget of {} sums to {} and not to {}", what, sum, expected));
}

int LostOf(const FailureBudget& budget) {
  return std::accumulate(budget.failures.begin(), budget.failures.end(), 0);
}

int ClearedIn(std::span<const TrialResult> trials) {
  return std::accumulate(trials.begin(), trials.end(), 0, [](int sum, const TrialResult& trial) {
    return sum + trial.instances_cleared;
  });
}

FailureBudget CountInstances(std::span<const TrialResult> trials) {
  FailureBudget budget;
  for (const TrialResult& trial : trials) {
    budget.total += trial.instances_dropped;
    for (const InstanceOutcome& instance_outcome : trial.outcomes) {
      budget.picked += instance_outcome.picked;
      budget.not_asked += !instance_outcome.asked;
      if (instance_outcome.failure != FailureReason::kNone)
        AddFailure(instance_outcome.failure, budget);
    }
  }
  return budget;
}

// Returns one cluster per trial: count(budget) of budget.asked().
template <typename CountOf>
std::vector<Cluster> ClustersOf(const std::vector<FailureBudget>& by_trial, CountOf&& count) {
  std::vector<Cluster> clusters;
  for (const FailureBudget& budget : by_trial) clusters.push_back({count(budget), budget.asked()});
  return clusters;
}

using BudgetMaker = FailureBudget (*)(std::span<const TrialResult> trials);

std::vector<FailureBudget> ByTrial(std::span<const TrialResult> trials, BudgetMaker make) {
  std::vector<FailureBudget> by_trial;
  for (const TrialResult& trial : trials) by_trial.push_back(make({&trial, 1}));
  return by_trial;
}

std::vector<Cluster> PickedByTrial(const std::vector<FailureBudget>& by_trial) {
  return ClustersOf(by_trial, [](const FailureBudget& budget) { return budget.picked; });
}

BudgetShares SharesOf(std::span<const TrialResult> trials, BudgetMaker make) {
  const std::vector<FailureBudget> by_trial = ByTrial(trials, make);
  BudgetShares shares;
  shares.budget = make(trials);
  shares.picked = ClusterInterval(PickedByTrial(by_trial));
  for (const FailureRow& row : FailureTable()) {
    shares.failures.at(static_cast<size_t>(row.failure)) = ClusterInterval(
        ClustersOf(by_trial, [&](const FailureBudget& budget) { return budget[row.failure]; }));
  }
  return shares;
}

}  // namespace

int FailureBudget::Of(Stage stage) const {
  int sum = 0;
  for (const FailureRow& row : FailureTable()) {
    if (row.stage == stage) sum += (*this)[row.failure];
  }
  return sum;
}

FailureBudget BudgetOfAttempts(std::span<const TrialResult> trials) {
  FailureBudget budget;
  for (const TrialResult& trial : trials) {
    budget.total += static_cast<int>(trial.attempts.size());
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.failure != FailureReason::kNone) {
        AddFailure(attempt.failure, budget);
      } else {
        budget.picked += attempt.grasp.has_value();
      }
    }
  }
  RequireSum("attempts", budget.picked + LostOf(budget), budget.total);
  RequireSum("successful attempts", budget.picked, ClearedIn(trials));
  return budget;
}

FailureBudget BudgetOfInstances(std::span<const TrialResult> trials) {
  const FailureBudget budget = CountInstances(trials);
  RequireSum("instances", budget.picked + budget.not_asked + LostOf(budget), budget.total);
  RequireSum("picked instances", budget.picked, ClearedIn(trials));
  return budget;
}

bool OutcomesAddUp(const TrialResult& trial) {
  const FailureBudget budget = CountInstances({&trial, 1});
  return budget.picked + budget.not_asked + LostOf(budget) == budget.total &&
         budget.picked == trial.instances_cleared;
}

void RequireGraspFailuresOnly(const FailureBudget& budget) {
  for (const Stage stage : {Stage::kSense, Stage::kDetect, Stage::kPose, Stage::kRefine}) {
    if (budget.Of(stage) == 0) continue;
    throw std::logic_error(
        fmt::format("{} failures are attributed to the stage '{}', which used ground truth",
                    budget.Of(stage), StageName(stage)));
  }
}

std::vector<Cluster> AttemptsByTrial(std::span<const TrialResult> trials) {
  return PickedByTrial(ByTrial(trials, BudgetOfAttempts));
}

std::vector<Cluster> InstancesByTrial(std::span<const TrialResult> trials) {
  return PickedByTrial(ByTrial(trials, BudgetOfInstances));
}

BudgetShares SharesOfAttempts(std::span<const TrialResult> trials) {
  return SharesOf(trials, BudgetOfAttempts);
}

BudgetShares SharesOfInstances(std::span<const TrialResult> trials) {
  return SharesOf(trials, BudgetOfInstances);
}

}  // namespace pickbed::eval
