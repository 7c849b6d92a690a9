#pragma once

// Where picks are lost, as two budgets whose parts sum exactly to all.
//
// - Attempts: every look at a bin that held wanted parts asks for one of them. It is picked or lost
//   for one reason; looks that found no grasp are among the lost.
// - Instances: every wanted part that was dropped is picked, or lost for one reason, or was not
//   asked for (eval/fates.h).

#include <array>
#include <span>

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
  int asked() const { return total - not_asked; }
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

}  // namespace pickbed
