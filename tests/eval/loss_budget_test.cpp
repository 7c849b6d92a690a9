#include "eval/loss_budget.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace pickbed {
namespace {

PickRecord Look(int pick, const std::vector<int>& instances, Loss loss, int aimed = -1) {
  PickRecord record;
  record.pick = pick;
  for (const int instance : instances) record.instances.push_back({instance, 0, 0.9, true});
  record.loss = loss;
  record.aimed = aimed;
  record.grasp = Grasp();
  record.outcome.loss = loss;
  record.outcome.success = loss == Loss::kNone;
  if (loss == Loss::kNone) record.outcome.picked_instance = aimed;
  return record;
}

TrialResult TrialOf(int parts, const std::vector<PickRecord>& picks, const TrialEnd& end) {
  TrialResult trial;
  trial.parts_dropped = parts;
  trial.picks = picks;
  std::vector<InstanceFate> fates(parts);
  for (int i = 0; i < parts; ++i) fates[i].instance = i;
  for (const PickRecord& pick : picks) trial.parts_cleared += pick.loss == Loss::kNone;
  trial.fates = FatesOf(fates, picks, end);
  return trial;
}

// Losses of a look that finds no grasp.
bool IsWithoutGrasp(Loss loss) {
  return loss == Loss::kNotVisible || loss == Loss::kNoProposal || loss == Loss::kNoGrasp;
}

// Part 0 is picked; the second look is lost for the reason and ends the trial, and with it part 1.
TEST(LossBudget, EveryReasonIsChargedOnceInBothBudgets) {
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone) continue;
    std::vector<PickRecord> picks{Look(0, {0, 1}, Loss::kNone, 0)};
    if (IsWithoutGrasp(row.loss)) {
      picks.push_back(Look(1, {1}, row.loss));
      picks.back().grasp.reset();
      if (row.loss != Loss::kNoGrasp) picks.back().instances[0].missed = row.loss;
    } else {
      picks.push_back(Look(1, {1}, row.loss, 1));
    }
    const TrialResult trial = TrialOf(2, picks, {{1}, true});
    for (const LossBudget& budget :
         {BudgetOfAttempts({&trial, 1}), BudgetOfInstances({&trial, 1})}) {
      EXPECT_EQ(budget.total, 2) << row.name;
      EXPECT_EQ(budget.picked, 1) << row.name;
      EXPECT_EQ(budget.not_asked, 0) << row.name;
      for (const LossRow& other : LossTable()) {
        EXPECT_EQ(budget[other.loss], other.loss == row.loss) << row.name << " as " << other.name;
      }
      EXPECT_EQ(budget.Of(row.stage), 1) << row.name;
    }
  }
}

TEST(LossBudget, ThrowsWhenThePartsDoNotSum) {
  const TrialResult fair =
      TrialOf(2, {Look(0, {0, 1}, Loss::kNone, 0), Look(1, {1}, Loss::kSlipped, 1)}, {{1}, true});
  EXPECT_NO_THROW(BudgetOfAttempts({&fair, 1}));
  EXPECT_NO_THROW(BudgetOfInstances({&fair, 1}));
  TrialResult bad = fair;
  bad.fates[1].loss = Loss::kNone;  // neither picked nor lost
  EXPECT_THROW(BudgetOfInstances({&bad, 1}), std::logic_error);
  bad = fair;
  bad.fates[0].loss = Loss::kDropped;  // picked and lost
  EXPECT_THROW(BudgetOfInstances({&bad, 1}), std::logic_error);
  bad = fair;
  bad.fates.pop_back();
  EXPECT_THROW(BudgetOfInstances({&bad, 1}), std::logic_error);
  bad = fair;
  bad.parts_cleared = 2;
  EXPECT_THROW(BudgetOfAttempts({&bad, 1}), std::logic_error);
  bad = fair;
  bad.picks[0].grasp.reset();  // a success without a grasp
  EXPECT_THROW(BudgetOfAttempts({&bad, 1}), std::logic_error);
}

TEST(LossBudget, WithTruthEverywhereTheHandAloneMayLose) {
  for (const LossRow& row : LossTable()) {
    LossBudget budget;
    budget.lost[static_cast<size_t>(row.loss)] = 1;
    const bool of_perception = row.stage == Stage::kSense || row.stage == Stage::kDetect ||
                               row.stage == Stage::kPose || row.stage == Stage::kRefine;
    if (of_perception) {
      EXPECT_THROW(RequireGraspLossesOnly(budget), std::logic_error) << row.name;
    } else {
      EXPECT_NO_THROW(RequireGraspLossesOnly(budget)) << row.name;
    }
  }
}

InstanceFate FateOf(const TrialResult& trial, int instance) { return trial.fates.at(instance); }

TEST(Fates, PartsThatLeaveByAFailedPick) {
  // Part 0 is the aim and falls outside, 1 comes along in the hand, 2 is knocked out by a success.
  PickRecord two = Look(0, {0, 1, 2, 3}, Loss::kTookTwo, 0);
  two.outcome.parts_lifted = 2;
  const TrialResult trial = TrialOf(4, {two, Look(1, {2, 3}, Loss::kNone, 3)}, {{}, false});
  EXPECT_EQ(FateOf(trial, 0).loss, Loss::kTookTwo);
  EXPECT_EQ(FateOf(trial, 1).loss, Loss::kTookTwo);
  EXPECT_EQ(FateOf(trial, 2).loss, Loss::kDisturbed);
  EXPECT_EQ(FateOf(trial, 2).pick, 1);
  EXPECT_TRUE(FateOf(trial, 3).picked);

  PickRecord dropped = Look(0, {0, 1, 2}, Loss::kDropped, 0);
  const TrialResult outside = TrialOf(3, {dropped, Look(1, {2}, Loss::kNone, 2)}, {{}, false});
  EXPECT_EQ(FateOf(outside, 0).loss, Loss::kDropped);
  EXPECT_EQ(FateOf(outside, 1).loss, Loss::kDisturbed);

  PickRecord instead = Look(0, {0, 1}, Loss::kPoseWrong, 0);
  instead.outcome.loss = Loss::kWrongPart;
  instead.outcome.picked_instance = 1;
  const TrialResult other = TrialOf(2, {instead, Look(1, {0}, Loss::kNone, 0)}, {{}, false});
  EXPECT_EQ(FateOf(other, 1).loss, Loss::kTookTwo);
  EXPECT_TRUE(FateOf(other, 0).picked);
}

TEST(Fates, PartsThatRemain) {
  // 0 was aimed at first; failed picks end the trial, the last of them at 1; 2 never had its turn.
  const std::vector<PickRecord> failures{Look(0, {0, 1, 2}, Loss::kCollision, 0),
                                         Look(1, {0, 1, 2}, Loss::kSlipped, 1)};
  const TrialResult tired = TrialOf(3, failures, {{0, 1, 2}, true});
  EXPECT_EQ(FateOf(tired, 0).loss, Loss::kCollision);
  EXPECT_EQ(FateOf(tired, 1).loss, Loss::kSlipped);
  EXPECT_EQ(FateOf(tired, 2).loss, Loss::kSlipped);

  // The same picks when the number of picks was reached.
  const TrialResult limited = TrialOf(3, failures, {{0, 1, 2}, false});
  EXPECT_EQ(FateOf(limited, 0).loss, Loss::kCollision);
  EXPECT_FALSE(FateOf(limited, 2).asked);
  EXPECT_EQ(FateOf(limited, 2).loss, Loss::kNone);
  EXPECT_EQ(BudgetOfInstances({&limited, 1}).not_asked, 1);
  EXPECT_EQ(BudgetOfInstances({&limited, 1}).asked(), 2);

  // A look without a grasp: each by what it was to the look.
  PickRecord blind = Look(0, {0, 1, 2}, Loss::kNoGrasp);
  blind.grasp.reset();
  blind.instances[1].missed = Loss::kNotVisible;
  blind.instances[2].missed = Loss::kSuppressed;
  const TrialResult stuck = TrialOf(3, {blind}, {{0, 1, 2}, true});
  EXPECT_EQ(FateOf(stuck, 0).loss, Loss::kNoGrasp);
  EXPECT_EQ(FateOf(stuck, 1).loss, Loss::kNotVisible);
  EXPECT_EQ(FateOf(stuck, 2).loss, Loss::kSuppressed);
}

// A look that ends without a grasp, or with one at a pose that stood on nothing.
PickRecord Aimless(int pick, const std::vector<double>& visible, Loss loss, bool executed) {
  PickRecord record = Look(pick, {}, loss);
  for (const double share : visible) {
    record.instances.push_back({static_cast<int>(record.instances.size()), 0, share, false, loss});
  }
  if (!executed) record.grasp.reset();
  return record;
}

TEST(Fates, EachLookOfALimitedTrialAsksForOnePart) {
  for (const bool executed : {false, true}) {
    // Of the first part that the camera saw it saw less than of the second.
    const PickRecord blind = Aimless(0, {0.2, 0.9, 0.5}, Loss::kPoseWrong, executed);
    const TrialResult one = TrialOf(3, {blind}, {{0, 1, 2}, false});
    EXPECT_EQ(FateOf(one, 1).loss, Loss::kPoseWrong);
    EXPECT_EQ(FateOf(one, 1).pick, 0);
    const LossBudget parts = BudgetOfInstances({&one, 1}), looks = BudgetOfAttempts({&one, 1});
    EXPECT_EQ(parts.asked(), looks.asked()) << "one look, one part";
    EXPECT_EQ(parts[Loss::kPoseWrong], looks[Loss::kPoseWrong]);

    // The next look asks for another part; a third for none, since none is left to ask for.
    PickRecord second = Aimless(1, {0.2, 0.9, 0.5}, Loss::kNoGrasp, false);
    PickRecord third = Look(2, {0, 1, 2}, Loss::kSlipped, 0);
    const TrialResult more = TrialOf(3, {blind, second, third}, {{0, 1, 2}, false});
    EXPECT_EQ(FateOf(more, 1).loss, Loss::kPoseWrong);
    EXPECT_EQ(FateOf(more, 2).loss, Loss::kNoGrasp);
    EXPECT_EQ(FateOf(more, 0).loss, Loss::kSlipped);
    EXPECT_EQ(BudgetOfInstances({&more, 1}).not_asked, 0);
  }
  // A phantom's grasp that brought a part to nobody has cost the bin that part.
  PickRecord instead = Look(0, {0, 1, 2}, Loss::kPoseWrong);
  instead.outcome.loss = Loss::kWrongPart;
  instead.outcome.picked_instance = 2;
  const TrialResult cost = TrialOf(3, {instead}, {{0, 1}, false});
  EXPECT_EQ(FateOf(cost, 2).loss, Loss::kTookTwo);
  EXPECT_EQ(BudgetOfInstances({&cost, 1}).asked(), 1);
}

// What the issue is about: a bin that finds no grasp counts as one that fails, so that a gain is
// not measured against the bins alone that found one.
TEST(LossBudget, BinsThatFindNoGraspCountInTheRateOfInstances) {
  std::vector<TrialResult> trials{
      TrialOf(2, {Aimless(0, {0.5, 0.4}, Loss::kNoGrasp, false)}, {{0, 1}, false}),
      TrialOf(2, {Look(0, {0, 1}, Loss::kNone, 0)}, {{1}, false})};
  const LossBudget parts = BudgetOfInstances(trials);
  EXPECT_EQ(parts.asked(), 2);
  EXPECT_EQ(parts.picked, 1);
  const std::vector<Cluster> clusters = InstancesByTrial(trials);
  EXPECT_EQ(clusters[0].tries, 1);
  EXPECT_EQ(clusters[0].hits, 0);
}

// Ten bins, a quarter of all looks slipped: the interval is wider where whole bins slip.
TEST(LossBudget, IntervalsOfSharesAreOverBins) {
  const auto trials = [](bool by_bin) {
    std::vector<TrialResult> all;
    for (int bin = 0; bin < 12; ++bin) {
      std::vector<PickRecord> picks;
      std::vector<int> remaining;
      for (int i = 0; i < 4; ++i) {
        const bool slips = by_bin ? bin % 4 == 0 : i == bin % 4;
        std::vector<int> seen = remaining;
        for (int part = i; part < 4; ++part) seen.push_back(part);
        picks.push_back(Look(i, seen, slips ? Loss::kSlipped : Loss::kNone, i));
        if (slips) remaining.push_back(i);
      }
      all.push_back(TrialOf(4, picks, {remaining, false}));
    }
    return all;
  };
  const auto spread = trials(false), clustered = trials(true);
  for (const auto shares_of : {SharesOfAttempts, SharesOfInstances}) {
    const BudgetShares even = shares_of(spread), uneven = shares_of(clustered);
    EXPECT_EQ(even.budget[Loss::kSlipped], 12);
    EXPECT_EQ(uneven.budget[Loss::kSlipped], 12);
    const Interval& narrow = even[Loss::kSlipped];
    const Interval& wide = uneven[Loss::kSlipped];
    EXPECT_GT(wide.high - wide.low, narrow.high - narrow.low);
    EXPECT_LT(wide.low, 0.25);
    EXPECT_GT(wide.high, 0.25);
    EXPECT_NEAR(wide.low, 1 - uneven.picked.high, 0.05) << "one reason alone: the rest is picked";
    EXPECT_NEAR(wide.high, 1 - uneven.picked.low, 0.05);
  }
}

TEST(Fates, APartThatAppearsFromNowhereIsOurFault) {
  EXPECT_THROW(TrialOf(2, {Look(0, {0}, Loss::kNone, 0)}, {{}, false}), std::logic_error);
  EXPECT_THROW(
      TrialOf(2, {Look(0, {0, 1}, Loss::kNone, 0), Look(1, {}, Loss::kSlipped)}, {{1}, true}),
      std::logic_error);
}

}  // namespace
}  // namespace pickbed
