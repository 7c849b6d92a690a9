#include "eval/summary/failure_budget.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

AttemptRecord Attempt(int pick, const std::vector<int>& instances, FailureReason failure,
                      int matched_instance = -1) {
  AttemptRecord record;
  record.attempt = pick;
  for (const int i : instances) {
    record.instances.push_back({InstanceId(i), ObjectId{0}, 0.9, true});
  }
  record.failure = failure;
  record.matched_instance = InstanceId(matched_instance);
  record.grasp = Grasp();
  record.outcome.failure = failure;
  record.outcome.success = failure == FailureReason::kNone;
  if (failure == FailureReason::kNone)
    record.outcome.picked_instance = InstanceId(matched_instance);
  return record;
}

// The end of a trial that leaves these instances in the bin.
TrialEnd End(const std::vector<int>& remaining, bool gave_up) {
  TrialEnd end;
  for (const int i : remaining) end.remaining.push_back(InstanceId(i));
  end.gave_up = gave_up;
  return end;
}

TrialResult TrialOf(int instances, const std::vector<AttemptRecord>& picks, const TrialEnd& end) {
  TrialResult trial;
  trial.instances_dropped = instances;
  trial.attempts = picks;
  std::vector<InstanceOutcome> outcomes(instances);
  for (int i = 0; i < instances; ++i) outcomes[i].instance = InstanceId(i);
  for (const AttemptRecord& pick : picks)
    trial.instances_cleared += pick.failure == FailureReason::kNone;
  trial.outcomes = DecideOutcomes(outcomes, picks, end);
  return trial;
}

// Failure reasons of an attempt without a grasp.
bool IsWithoutGrasp(FailureReason failure) {
  return failure == FailureReason::kNotVisible || failure == FailureReason::kNoProposal ||
         failure == FailureReason::kNoGrasp;
}

// Instance 0 is picked. The second attempt, at instance 1, fails for the given reason and ends the
// trial.
TEST(FailureBudget, EveryReasonCountsOnceInBothBudgets) {
  for (const FailureRow& row : FailureTable()) {
    if (row.failure == FailureReason::kNone) continue;
    std::vector<AttemptRecord> picks{Attempt(0, {0, 1}, FailureReason::kNone, 0)};
    if (IsWithoutGrasp(row.failure)) {
      picks.push_back(Attempt(1, {1}, row.failure));
      picks.back().grasp.reset();
      if (row.failure != FailureReason::kNoGrasp) picks.back().instances[0].missed = row.failure;
    } else {
      picks.push_back(Attempt(1, {1}, row.failure, 1));
    }
    const TrialResult trial = TrialOf(2, picks, End({1}, true));
    for (const FailureBudget& budget :
         {BudgetOfAttempts({&trial, 1}), BudgetOfInstances({&trial, 1})}) {
      EXPECT_EQ(budget.total, 2) << row.name;
      EXPECT_EQ(budget.picked, 1) << row.name;
      EXPECT_EQ(budget.not_asked, 0) << row.name;
      for (const FailureRow& other : FailureTable()) {
        EXPECT_EQ(budget[other.failure], other.failure == row.failure)
            << row.name << " as " << other.name;
      }
      EXPECT_EQ(budget.Of(row.stage), 1) << row.name;
    }
  }
}

TEST(FailureBudget, ThrowsIfTheSharesDoNotSumToTheTotal) {
  const TrialResult fair = TrialOf(
      2, {Attempt(0, {0, 1}, FailureReason::kNone, 0), Attempt(1, {1}, FailureReason::kSlipped, 1)},
      End({1}, true));
  EXPECT_NO_THROW(BudgetOfAttempts({&fair, 1}));
  EXPECT_NO_THROW(BudgetOfInstances({&fair, 1}));
  EXPECT_TRUE(OutcomesAddUp(fair));
  TrialResult bad = fair;
  bad.outcomes[1].failure = FailureReason::kNone;  // neither picked nor failed
  EXPECT_THROW(BudgetOfInstances({&bad, 1}), std::logic_error);
  EXPECT_FALSE(OutcomesAddUp(bad));
  bad = fair;
  bad.outcomes[0].failure = FailureReason::kDropped;  // picked and failed
  EXPECT_THROW(BudgetOfInstances({&bad, 1}), std::logic_error);
  EXPECT_FALSE(OutcomesAddUp(bad));
  bad = fair;
  bad.outcomes.pop_back();
  EXPECT_THROW(BudgetOfInstances({&bad, 1}), std::logic_error);
  EXPECT_FALSE(OutcomesAddUp(bad));
  bad = fair;
  bad.instances_cleared = 2;
  EXPECT_FALSE(OutcomesAddUp(bad));
  EXPECT_THROW(BudgetOfAttempts({&bad, 1}), std::logic_error);
  bad = fair;
  bad.attempts[0].grasp.reset();  // a success without a grasp
  EXPECT_THROW(BudgetOfAttempts({&bad, 1}), std::logic_error);
}

TEST(FailureBudget, WithGroundTruthOnlyGraspFailuresAreAllowed) {
  for (const FailureRow& row : FailureTable()) {
    FailureBudget budget;
    budget.failures[static_cast<size_t>(row.failure)] = 1;
    const bool of_perception = row.stage == Stage::kSense || row.stage == Stage::kDetect ||
                               row.stage == Stage::kPose || row.stage == Stage::kRefine;
    if (of_perception) {
      EXPECT_THROW(RequireGraspFailuresOnly(budget), std::logic_error) << row.name;
    } else {
      EXPECT_NO_THROW(RequireGraspFailuresOnly(budget)) << row.name;
    }
  }
}

InstanceOutcome OutcomeOf(const TrialResult& trial, InstanceId instance) {
  return trial.outcomes.at(instance);
}

TEST(InstanceOutcomes, InstancesThatLeaveTheBinByAFailedPick) {
  // Instance 0 is the target and falls outside. Instance 1 is lifted with it. A later success
  // displaces instance 2 out of the bin.
  AttemptRecord two = Attempt(0, {0, 1, 2, 3}, FailureReason::kDoublePick, 0);
  two.outcome.instances_lifted = 2;
  const TrialResult trial =
      TrialOf(4, {two, Attempt(1, {2, 3}, FailureReason::kNone, 3)}, End({}, false));
  EXPECT_EQ(OutcomeOf(trial, InstanceId{0}).failure, FailureReason::kDoublePick);
  EXPECT_EQ(OutcomeOf(trial, InstanceId{1}).failure, FailureReason::kDoublePick);
  EXPECT_EQ(OutcomeOf(trial, InstanceId{2}).failure, FailureReason::kNeighborDisplaced);
  EXPECT_EQ(OutcomeOf(trial, InstanceId{2}).attempt, 1);
  EXPECT_TRUE(OutcomeOf(trial, InstanceId{3}).picked);

  AttemptRecord hooked = Attempt(0, {0, 1, 2}, FailureReason::kEntangled, 0);
  hooked.outcome.instances_entangled = 1;
  const TrialResult tangle =
      TrialOf(3, {hooked, Attempt(1, {2}, FailureReason::kNone, 2)}, End({}, false));
  EXPECT_EQ(OutcomeOf(tangle, InstanceId{0}).failure, FailureReason::kEntangled);
  EXPECT_EQ(OutcomeOf(tangle, InstanceId{1}).failure, FailureReason::kEntangled);

  AttemptRecord dropped = Attempt(0, {0, 1, 2}, FailureReason::kDropped, 0);
  const TrialResult outside =
      TrialOf(3, {dropped, Attempt(1, {2}, FailureReason::kNone, 2)}, End({}, false));
  EXPECT_EQ(OutcomeOf(outside, InstanceId{0}).failure, FailureReason::kDropped);
  EXPECT_EQ(OutcomeOf(outside, InstanceId{1}).failure, FailureReason::kNeighborDisplaced);

  AttemptRecord other_lifted = Attempt(0, {0, 1}, FailureReason::kPoseWrong, 0);
  other_lifted.outcome.failure = FailureReason::kWrongObject;
  other_lifted.outcome.picked_instance = InstanceId{1};
  const TrialResult other =
      TrialOf(2, {other_lifted, Attempt(1, {0}, FailureReason::kNone, 0)}, End({}, false));
  EXPECT_EQ(OutcomeOf(other, InstanceId{1}).failure, FailureReason::kDoublePick);
  EXPECT_TRUE(OutcomeOf(other, InstanceId{0}).picked);
}

TEST(InstanceOutcomes, InstancesThatRemainInTheBin) {
  // The first target is 0. Failed picks end the trial, the last one at 1. Instance 2 is never a
  // target.
  const std::vector<AttemptRecord> failures{Attempt(0, {0, 1, 2}, FailureReason::kCollision, 0),
                                            Attempt(1, {0, 1, 2}, FailureReason::kSlipped, 1)};
  const TrialResult given_up = TrialOf(3, failures, End({0, 1, 2}, true));
  EXPECT_EQ(OutcomeOf(given_up, InstanceId{0}).failure, FailureReason::kCollision);
  EXPECT_EQ(OutcomeOf(given_up, InstanceId{1}).failure, FailureReason::kSlipped);
  EXPECT_EQ(OutcomeOf(given_up, InstanceId{2}).failure, FailureReason::kSlipped);

  // The same picks, but the trial ends because it reached its number of picks.
  const TrialResult limited = TrialOf(3, failures, End({0, 1, 2}, false));
  EXPECT_EQ(OutcomeOf(limited, InstanceId{0}).failure, FailureReason::kCollision);
  EXPECT_FALSE(OutcomeOf(limited, InstanceId{2}).asked);
  EXPECT_EQ(OutcomeOf(limited, InstanceId{2}).failure, FailureReason::kNone);
  EXPECT_EQ(BudgetOfInstances({&limited, 1}).not_asked, 1);
  EXPECT_EQ(BudgetOfInstances({&limited, 1}).asked(), 2);

  // An attempt without a grasp: each instance has the reason why the attempt missed it.
  AttemptRecord without_grasp = Attempt(0, {0, 1, 2}, FailureReason::kNoGrasp);
  without_grasp.grasp.reset();
  without_grasp.instances[1].missed = FailureReason::kNotVisible;
  without_grasp.instances[2].missed = FailureReason::kSuppressed;
  const TrialResult stuck = TrialOf(3, {without_grasp}, End({0, 1, 2}, true));
  EXPECT_EQ(OutcomeOf(stuck, InstanceId{0}).failure, FailureReason::kNoGrasp);
  EXPECT_EQ(OutcomeOf(stuck, InstanceId{1}).failure, FailureReason::kNotVisible);
  EXPECT_EQ(OutcomeOf(stuck, InstanceId{2}).failure, FailureReason::kSuppressed);
}

// An attempt without a target: without a grasp, or with a grasp at a pose on no instance.
AttemptRecord AttemptWithoutTarget(int pick, const std::vector<double>& visible,
                                   FailureReason failure, bool executed) {
  AttemptRecord record = Attempt(pick, {}, failure);
  for (const double share : visible) {
    record.instances.push_back(
        {InstanceId(record.instances.size()), ObjectId{0}, share, false, failure});
  }
  if (!executed) record.grasp.reset();
  return record;
}

TEST(InstanceOutcomes, EachAttemptOfALimitedTrialRequestsOneInstance) {
  for (const bool executed : {false, true}) {
    // The camera sees less of instance 0 than of instance 1.
    const AttemptRecord without_grasp =
        AttemptWithoutTarget(0, {0.2, 0.9, 0.5}, FailureReason::kPoseWrong, executed);
    const TrialResult one = TrialOf(3, {without_grasp}, End({0, 1, 2}, false));
    EXPECT_EQ(OutcomeOf(one, InstanceId{1}).failure, FailureReason::kPoseWrong);
    EXPECT_EQ(OutcomeOf(one, InstanceId{1}).attempt, 0);
    const FailureBudget instances = BudgetOfInstances({&one, 1}),
                        attempts = BudgetOfAttempts({&one, 1});
    EXPECT_EQ(instances.asked(), attempts.asked()) << "one attempt requests one instance";
    EXPECT_EQ(instances[FailureReason::kPoseWrong], attempts[FailureReason::kPoseWrong]);

    // The second attempt requests another instance. The third has instance 0 as its target.
    AttemptRecord second = AttemptWithoutTarget(1, {0.2, 0.9, 0.5}, FailureReason::kNoGrasp, false);
    AttemptRecord third = Attempt(2, {0, 1, 2}, FailureReason::kSlipped, 0);
    const TrialResult more = TrialOf(3, {without_grasp, second, third}, End({0, 1, 2}, false));
    EXPECT_EQ(OutcomeOf(more, InstanceId{1}).failure, FailureReason::kPoseWrong);
    EXPECT_EQ(OutcomeOf(more, InstanceId{2}).failure, FailureReason::kNoGrasp);
    EXPECT_EQ(OutcomeOf(more, InstanceId{0}).failure, FailureReason::kSlipped);
    EXPECT_EQ(BudgetOfInstances({&more, 1}).not_asked, 0);
  }
  // A grasp at a pose on no instance that still lifts an instance costs the bin that instance.
  AttemptRecord other_lifted = Attempt(0, {0, 1, 2}, FailureReason::kPoseWrong);
  other_lifted.outcome.failure = FailureReason::kWrongObject;
  other_lifted.outcome.picked_instance = InstanceId{2};
  const TrialResult cost = TrialOf(3, {other_lifted}, End({0, 1}, false));
  EXPECT_EQ(OutcomeOf(cost, InstanceId{2}).failure, FailureReason::kDoublePick);
  EXPECT_EQ(BudgetOfInstances({&cost, 1}).asked(), 1);
}

// A bin without a grasp counts as a failure, so that gains are not measured only on bins with a
// grasp.
TEST(FailureBudget, BinsWithoutAGraspCountInTheInstanceRate) {
  std::vector<TrialResult> trials{
      TrialOf(2, {AttemptWithoutTarget(0, {0.5, 0.4}, FailureReason::kNoGrasp, false)},
              End({0, 1}, false)),
      TrialOf(2, {Attempt(0, {0, 1}, FailureReason::kNone, 0)}, End({1}, false))};
  const FailureBudget instances = BudgetOfInstances(trials);
  EXPECT_EQ(instances.asked(), 2);
  EXPECT_EQ(instances.picked, 1);
  const std::vector<Cluster> clusters = InstancesByTrial(trials);
  EXPECT_EQ(clusters[0].samples, 1);
  EXPECT_EQ(clusters[0].hits, 0);
}

// Twelve bins in which a quarter of all attempts slip. The interval is wider if whole bins slip.
TEST(FailureBudget, ShareIntervalsAreOverBins) {
  const auto trials = [](bool by_bin) {
    std::vector<TrialResult> all;
    for (int bin = 0; bin < 12; ++bin) {
      std::vector<AttemptRecord> picks;
      std::vector<int> remaining;
      for (int i = 0; i < 4; ++i) {
        const bool slips = by_bin ? bin % 4 == 0 : i == bin % 4;
        std::vector<int> seen = remaining;
        for (int instance = i; instance < 4; ++instance) seen.push_back(instance);
        picks.push_back(
            Attempt(i, seen, slips ? FailureReason::kSlipped : FailureReason::kNone, i));
        if (slips) remaining.push_back(i);
      }
      all.push_back(TrialOf(4, picks, End(remaining, false)));
    }
    return all;
  };
  const auto spread = trials(false), clustered = trials(true);
  for (const auto shares_of : {SharesOfAttempts, SharesOfInstances}) {
    const BudgetShares even = shares_of(spread), uneven = shares_of(clustered);
    EXPECT_EQ(even.budget[FailureReason::kSlipped], 12);
    EXPECT_EQ(uneven.budget[FailureReason::kSlipped], 12);
    const Interval& narrow = even[FailureReason::kSlipped];
    const Interval& wide = uneven[FailureReason::kSlipped];
    EXPECT_GT(wide.high - wide.low, narrow.high - narrow.low);
    EXPECT_LT(wide.low, 0.25);
    EXPECT_GT(wide.high, 0.25);
    EXPECT_NEAR(wide.low, 1 - uneven.picked.high, 0.05)
        << "there is only one reason, and the rest is picked";
    EXPECT_NEAR(wide.high, 1 - uneven.picked.low, 0.05);
  }
}

TEST(InstanceOutcomes, InstanceThatAppearsFromNowhereIsAnInternalError) {
  EXPECT_THROW(TrialOf(2, {Attempt(0, {0}, FailureReason::kNone, 0)}, End({}, false)),
               std::logic_error);
  EXPECT_THROW(
      TrialOf(
          2, {Attempt(0, {0, 1}, FailureReason::kNone, 0), Attempt(1, {}, FailureReason::kSlipped)},
          End({1}, true)),
      std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
