// Every reason of the enum planted once, from what a look knows to both budgets.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "eval/blame.h"
#include "eval/loss_budget.h"

namespace pickbed {
namespace {

// What one look of a bin with two parts believed and did. Part 0, of kind 0, is the one that is
// lost; part 1, of kind 1, lies half a metre along x.
struct Look {
  std::vector<PoseHypothesis> hypotheses;
  bool is_executed = false;  // the grasp of the first hypothesis
  GraspOutcome outcome;
  std::vector<double> visible{0.8, 0.7};
  std::vector<int> remaining{0, 1};
};

constexpr double kLeg_m = 0.04;
constexpr double kFarOff_m = 0.02;  // of a pose that is wrong and stands on the part all the same

PoseHypothesis Believe(const Pose& X_CO, int object = 0) {
  PoseHypothesis h;
  h.object = object;
  h.X_CO = X_CO;
  h.score = 1;
  return h;
}
PoseHypothesis Right() { return Believe(Translation({0.001, 0, 0})); }
PoseHypothesis Wrong() { return Believe(Translation({kFarOff_m, 0, 0})); }

// The hand's fault at a pose that is right.
Look Executed(Loss physical) {
  Look look;
  look.hypotheses = {Right()};
  look.is_executed = true;
  look.outcome.loss = physical;
  return look;
}
Look ExecutedAt(const PoseHypothesis& h) {
  Look look = Executed(Loss::kClosedOnNothing);  // as a hand does where nothing lies
  look.hypotheses = {h};
  return look;
}

struct Planted {
  Loss loss;
  Look look;
  Loss of_attempt;  // where it is not that of the part
};

std::vector<Planted> PlantedLosses() {
  std::vector<Planted> planted;
  const auto add = [&](Loss loss, const Look& look) { planted.push_back({loss, look, loss}); };
  Look unseen, unproposed, no_grasp;
  unseen.visible = {0.05, 0.02};
  no_grasp.hypotheses = {Right()};
  add(Loss::kNotVisible, unseen);
  add(Loss::kNoProposal, unproposed);
  add(Loss::kNoGrasp, no_grasp);
  add(Loss::kWrongPart, ExecutedAt(Believe(Pose::Identity(), 1)));
  add(Loss::kPoseWrong, ExecutedAt(Wrong()));
  PoseHypothesis undone = Wrong(), suppressing = Wrong();
  undone.unrefined_X_CO = Right().X_CO;
  suppressing.suppressed_X_CO = {Right().X_CO};
  add(Loss::kRefinementWorse, ExecutedAt(undone));
  add(Loss::kSuppressed, ExecutedAt(suppressing));
  Look instead = Executed(Loss::kWrongPart);  // another part came than the one that was meant
  add(Loss::kTookTwo, instead);
  // A pick of part 1 that succeeds and throws part 0 out.
  Look knocked = Executed(Loss::kNone);
  knocked.hypotheses = {Believe(Translation({0.5, 0, 0}), 1)};
  knocked.outcome.success = true;
  knocked.outcome.picked_instance = 1;
  knocked.remaining = {};
  planted.push_back({Loss::kDisturbed, knocked, Loss::kNone});
  // What physics says at a right pose stands as it is.
  for (const LossRow& row : LossTable()) {
    const bool of_hand = row.stage == Stage::kApproach || row.stage == Stage::kGrasp ||
                         row.stage == Stage::kSimulate;
    if (of_hand && row.loss != Loss::kDisturbed) add(row.loss, Executed(row.loss));
  }
  return planted;
}

class PlantedLoss : public ::testing::Test {
 protected:
  PlantedLoss() {
    MetricModel tripod;
    tripod.vertices_O = {{kLeg_m, 0, 0}, {0, kLeg_m, 0}, {0, 0, kLeg_m}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = std::sqrt(2.0) * kLeg_m;
    models_ = {tripod, tripod};
    scene_.objects = {{0, 0, Pose::Identity()}, {1, 1, Translation({0.5, 0, 0})}};
  }

  // As a trial of one look does it.
  TrialResult TrialOf(const Look& look) const {
    const LookTruth truth{scene_, models_, camera_};
    PickRecord record;
    LookScore score = ScoreLook(scene_, look.visible, models_, camera_, look.hypotheses);
    const std::vector<Loss> missed = WhyMissed(score, look.hypotheses, truth);
    for (size_t i = 0; i < missed.size(); ++i) score.instances[i].missed = missed[i];
    record.instances = score.instances;
    record.hypotheses = score.hypotheses;
    record.outcome = look.outcome;
    if (look.is_executed) {
      record.grasp = Grasp();
      record.chosen = 0;
      const HypothesisScore& chosen = record.hypotheses[0];
      record.aimed = chosen.mssd_diameters < kStandsOnDiameters ? chosen.instance : -1;
      record.loss = LossOf(record, look.hypotheses[0], truth);
    } else {
      record.loss = LossWithoutGrasp(record, look.hypotheses, truth);
    }
    TrialResult trial;
    trial.parts_dropped = 2;
    trial.parts_cleared = record.loss == Loss::kNone;
    trial.picks = {record};
    trial.fates = FatesOf({{0, 0}, {1, 1}}, trial.picks, {look.remaining, false});
    return trial;
  }

  std::vector<MetricModel> models_;
  Scene scene_;
  Camera camera_{{640, 480, 600, 600, 319.5, 239.5}, Pose::Identity()};
};

TEST_F(PlantedLoss, IsChargedToItsReasonInBothBudgets) {
  for (const Planted& planted : PlantedLosses()) {
    SCOPED_TRACE(LossName(planted.loss));
    const TrialResult trial = TrialOf(planted.look);
    EXPECT_EQ(LossName(trial.picks[0].loss), LossName(planted.of_attempt));
    const LossBudget attempts = BudgetOfAttempts({&trial, 1});
    const LossBudget instances = BudgetOfInstances({&trial, 1});
    for (const LossRow& row : LossTable()) {
      if (row.loss == Loss::kNone) continue;
      EXPECT_EQ(attempts[row.loss], row.loss == planted.of_attempt) << row.name;
      EXPECT_EQ(instances[row.loss], row.loss == planted.loss) << row.name;
    }
    // The one look asked for one part; what was thrown out comes to that.
    EXPECT_EQ(attempts.asked(), 1);
    EXPECT_EQ(instances.asked(), planted.loss == Loss::kDisturbed ? 2 : 1);
    EXPECT_EQ(trial.fates[0].loss, planted.loss);
  }
}

TEST_F(PlantedLoss, NoReasonIsLeftOut) {
  const std::vector<Planted> planted = PlantedLosses();
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone) continue;
    EXPECT_TRUE(std::any_of(planted.begin(), planted.end(),
                            [&](const Planted& p) { return p.loss == row.loss; }))
        << row.name << ": plant it above";
  }
}

}  // namespace
}  // namespace pickbed
