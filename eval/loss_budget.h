#pragma once

// Where picks are lost, as two budgets whose parts sum exactly to all.
//
// - Attempts: every look at a bin that held wanted parts asks for one of them. It is picked or lost
//   for one reason; looks that found no grasp are among the lost.
// - Instances: every wanted part that was dropped is picked, or lost for one reason, or was not
//   asked for (eval/fates.h). Asked for are the parts that looks asked for, one each, and those
//   that a pick cost the bin by the way; where a policy limits the looks these are few of all.
//
// Shares and rates are of what was asked for: of all attempts, and of the instances asked for.

#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "eval/statistics.h"
#include "eval/trial.h"
#include "scenes/loss.h"

namespace pickbed {

struct LossBudget {
  int total = 0;
  int picked = 0;
  int not_asked = 0;                                                      // of instances alone
  std::array<int, static_cast<size_t>(Loss::kPhysicsFailed) + 1> lost{};  // by loss; [kNone] = 0

  int operator[](Loss loss) const { return lost.at(static_cast<size_t>(loss)); }
  int asked() const { return total - not_asked; }  // picked + lost
  int Of(Stage stage) const;
};

// Both throw std::logic_error when the parts do not sum to all: to the looks, to the parts that
// were dropped, and to the parts that the trial counted as cleared.
LossBudget BudgetOfAttempts(std::span<const TrialResult> trials);
LossBudget BudgetOfInstances(std::span<const TrialResult> trials);

// Throws std::logic_error when a stage before the grasp lost something: with truth in place of all
// of perception only plan, approach and grasp may (and the simulation, where physics broke).
void RequireGraspLossesOnly(const LossBudget& budget);

// Picked of asked for, by trial: what intervals are made of.
std::vector<Cluster> AttemptsByTrial(std::span<const TrialResult> trials);
std::vector<Cluster> InstancesByTrial(std::span<const TrialResult> trials);

// A budget with the 95 % intervals of its shares. Losses of one bin are not independent, so that
// the intervals are over bins (eval/statistics.h).
struct BudgetShares {
  LossBudget budget;
  Interval picked;
  std::array<Interval, std::tuple_size_v<decltype(LossBudget::lost)>> lost;  // by loss

  const Interval& operator[](Loss loss) const { return lost.at(static_cast<size_t>(loss)); }
};
BudgetShares SharesOfAttempts(std::span<const TrialResult> trials);
BudgetShares SharesOfInstances(std::span<const TrialResult> trials);

}  // namespace pickbed
