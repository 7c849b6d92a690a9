#include "eval/loss_budget.h"

#include <fmt/format.h>

#include <numeric>
#include <stdexcept>

namespace pickbed {
namespace {

void Charge(Loss loss, LossBudget& budget) { ++budget.lost.at(static_cast<size_t>(loss)); }

void RequireSum(const char* what, int sum, int expected) {
  if (sum == expected) return;
  throw std::logic_error(
      fmt::format("the budget of {} sums to {} and not to {}", what, sum, expected));
}

int LostOf(const LossBudget& budget) {
  return std::accumulate(budget.lost.begin(), budget.lost.end(), 0);
}

int ClearedIn(std::span<const TrialResult> trials) {
  return std::accumulate(trials.begin(), trials.end(), 0, [](int sum, const TrialResult& trial) {
    return sum + trial.parts_cleared;
  });
}

// Of each trial what `count` takes from its budget, of what was asked for.
template <typename CountOf>
std::vector<Cluster> ClustersOf(const std::vector<LossBudget>& by_trial, CountOf&& count) {
  std::vector<Cluster> clusters;
  for (const LossBudget& budget : by_trial) clusters.push_back({count(budget), budget.asked()});
  return clusters;
}

using BudgetMaker = LossBudget (*)(std::span<const TrialResult> trials);

std::vector<LossBudget> ByTrial(std::span<const TrialResult> trials, BudgetMaker make) {
  std::vector<LossBudget> by_trial;
  for (const TrialResult& trial : trials) by_trial.push_back(make({&trial, 1}));
  return by_trial;
}

std::vector<Cluster> PickedByTrial(const std::vector<LossBudget>& by_trial) {
  return ClustersOf(by_trial, [](const LossBudget& budget) { return budget.picked; });
}

BudgetShares SharesOf(std::span<const TrialResult> trials, BudgetMaker make) {
  const std::vector<LossBudget> by_trial = ByTrial(trials, make);
  BudgetShares shares;
  shares.budget = make(trials);
  shares.picked = ClusterInterval(PickedByTrial(by_trial));
  for (const LossRow& row : LossTable()) {
    shares.lost.at(static_cast<size_t>(row.loss)) = ClusterInterval(
        ClustersOf(by_trial, [&](const LossBudget& budget) { return budget[row.loss]; }));
  }
  return shares;
}

}  // namespace

int LossBudget::Of(Stage stage) const {
  int sum = 0;
  for (const LossRow& row : LossTable()) {
    if (row.stage == stage) sum += (*this)[row.loss];
  }
  return sum;
}

LossBudget BudgetOfAttempts(std::span<const TrialResult> trials) {
  LossBudget budget;
  for (const TrialResult& trial : trials) {
    budget.total += static_cast<int>(trial.picks.size());
    for (const PickRecord& pick : trial.picks) {
      if (pick.loss != Loss::kNone) {
        Charge(pick.loss, budget);
      } else {
        budget.picked += pick.grasp.has_value();
      }
    }
  }
  RequireSum("attempts", budget.picked + LostOf(budget), budget.total);
  RequireSum("successful attempts", budget.picked, ClearedIn(trials));
  return budget;
}

LossBudget BudgetOfInstances(std::span<const TrialResult> trials) {
  LossBudget budget;
  for (const TrialResult& trial : trials) {
    budget.total += trial.parts_dropped;
    for (const InstanceFate& fate : trial.fates) {
      budget.picked += fate.picked;
      budget.not_asked += !fate.asked;
      if (fate.loss != Loss::kNone) Charge(fate.loss, budget);
    }
  }
  RequireSum("instances", budget.picked + budget.not_asked + LostOf(budget), budget.total);
  RequireSum("picked instances", budget.picked, ClearedIn(trials));
  return budget;
}

void RequireGraspLossesOnly(const LossBudget& budget) {
  for (const Stage stage : {Stage::kSense, Stage::kDetect, Stage::kPose, Stage::kRefine}) {
    if (budget.Of(stage) == 0) continue;
    throw std::logic_error(
        fmt::format("{} losses are charged to the stage '{}', which was fed "
                    "with truth",
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

}  // namespace pickbed
