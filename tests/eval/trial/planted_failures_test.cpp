// Plants every failure reason once and follows it from the attempt to both failure budgets.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "eval/summary/failure_budget.h"
#include "eval/trial/failure_attribution.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Hypotheses and outcome of one attempt at a bin with two instances. Instance 0 (object 0) is the
// one that fails. Instance 1 (object 1) is at x = 0.5 m.
struct PlantedAttempt {
  std::vector<PoseHypothesis> hypotheses;
  bool is_executed = false;  // whether the grasp of the first hypothesis is executed
  GraspOutcome outcome;
  std::vector<double> visible{0.8, 0.7};
  std::vector<InstanceId> remaining{InstanceId{0}, InstanceId{1}};
};

constexpr double kLeg_m = 0.04;
constexpr double kFarOff_m = 0.02;  // error of a wrong pose that still matches the instance

PoseHypothesis MakeHypothesis(const Pose& X_CO, ObjectId object = ObjectId{0}) {
  PoseHypothesis h;
  h.object = object;
  h.X_CO = X_CO;
  h.score = 1;
  return h;
}
PoseHypothesis Right() { return MakeHypothesis(Translation({0.001, 0, 0})); }
PoseHypothesis Wrong() { return MakeHypothesis(Translation({kFarOff_m, 0, 0})); }

// A grasp failure at a correct pose.
PlantedAttempt Executed(FailureReason physical) {
  PlantedAttempt attempt;
  attempt.hypotheses = {Right()};
  attempt.is_executed = true;
  attempt.outcome.failure = physical;
  return attempt;
}
PlantedAttempt ExecutedAt(const PoseHypothesis& h) {
  PlantedAttempt attempt =
      Executed(FailureReason::kClosedOnNothing);  // as the jaws do without an instance between them
  attempt.hypotheses = {h};
  return attempt;
}

struct Planted {
  FailureReason failure;
  PlantedAttempt attempt;
  FailureReason of_attempt;  // reason of the attempt; may differ from the reason of the instance
};

std::vector<Planted> PlantedFailures() {
  std::vector<Planted> planted;
  const auto add = [&](FailureReason failure, const PlantedAttempt& attempt) {
    planted.push_back({failure, attempt, failure});
  };
  PlantedAttempt unseen, unproposed, no_grasp;
  unseen.visible = {0.05, 0.02};
  no_grasp.hypotheses = {Right()};
  add(FailureReason::kNotVisible, unseen);
  add(FailureReason::kNoProposal, unproposed);
  add(FailureReason::kNoGrasp, no_grasp);
  add(FailureReason::kWrongObject, ExecutedAt(MakeHypothesis(Pose::Identity(), ObjectId{1})));
  add(FailureReason::kPoseWrong, ExecutedAt(Wrong()));
  PoseHypothesis undone = Wrong(), suppressing = Wrong();
  undone.unrefined_X_CO = Right().X_CO;
  suppressing.suppressed_X_CO = {Right().X_CO};
  add(FailureReason::kRefinementWorse, ExecutedAt(undone));
  add(FailureReason::kSuppressed, ExecutedAt(suppressing));
  PlantedAttempt other_lifted =
      Executed(FailureReason::kWrongObject);  // another instance than the target was lifted
  add(FailureReason::kDoublePick, other_lifted);
  // A successful pick of instance 1 that throws instance 0 out of the bin.
  PlantedAttempt displaced = Executed(FailureReason::kNone);
  displaced.hypotheses = {MakeHypothesis(Translation({0.5, 0, 0}), ObjectId{1})};
  displaced.outcome.success = true;
  displaced.outcome.picked_instance = InstanceId{1};
  displaced.remaining = {};
  planted.push_back({FailureReason::kNeighborDisplaced, displaced, FailureReason::kNone});
  // At a correct pose, the physical failure reason is kept.
  for (const FailureRow& row : FailureTable()) {
    const bool of_hand = row.stage == Stage::kApproach || row.stage == Stage::kGrasp ||
                         row.stage == Stage::kSimulate;
    if (of_hand && row.failure != FailureReason::kNeighborDisplaced)
      add(row.failure, Executed(row.failure));
  }
  return planted;
}

class PlantedFailure : public ::testing::Test {
 protected:
  PlantedFailure() {
    MetricModel tripod;
    tripod.vertices_O = {{kLeg_m, 0, 0}, {0, kLeg_m, 0}, {0, 0, kLeg_m}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = std::sqrt(2.0) * kLeg_m;
    models_ = {tripod, tripod};
    scene_.objects = {{InstanceId{0}, ObjectId{0}, Pose::Identity()},
                      {InstanceId{1}, ObjectId{1}, Translation({0.5, 0, 0})}};
  }

  // Fills the record in the same way as a trial with one attempt.
  TrialResult TrialOf(const PlantedAttempt& attempt) const {
    const InstanceMatcher truth(models_, InstancesOf(scene_, attempt.visible, camera_.X_CW()));
    AttemptRecord record;
    AttemptScore score = ScoreAgainstTruth(truth, camera_, attempt.hypotheses);
    const std::vector<FailureReason> missed = MissReasons(score, truth);
    for (size_t i = 0; i < missed.size(); ++i) score.instances[i].missed = missed[i];
    record.instances = score.instances;
    record.hypotheses = score.Records();
    record.outcome = attempt.outcome;
    if (attempt.is_executed) {
      record.grasp = Grasp();
      record.chosen = 0;
      const HypothesisRecord& chosen = record.hypotheses[0];
      record.matched_instance =
          chosen.mssd_diameters() < kMatchDiameters ? chosen.instance : kNoInstance;
    }
    record.failure = AttributeFailure(record, score.hypotheses, kMatchDiameters, truth);
    TrialResult trial;
    trial.instances_dropped = 2;
    trial.instances_cleared = record.failure == FailureReason::kNone;
    trial.attempts = {record};
    trial.outcomes = DecideOutcomes({{InstanceId{0}, ObjectId{0}}, {InstanceId{1}, ObjectId{1}}},
                                    trial.attempts, {attempt.remaining, false});
    return trial;
  }

  std::vector<MetricModel> models_;
  Scene scene_;
  Camera camera_{{640, 480, 600, 600, 319.5, 239.5}, Pose::Identity()};
};

TEST_F(PlantedFailure, IsAttributedToItsReasonInBothBudgets) {
  for (const Planted& planted : PlantedFailures()) {
    SCOPED_TRACE(FailureName(planted.failure));
    const TrialResult trial = TrialOf(planted.attempt);
    EXPECT_EQ(FailureName(trial.attempts[0].failure), FailureName(planted.of_attempt));
    const FailureBudget attempts = BudgetOfAttempts({&trial, 1});
    const FailureBudget instances = BudgetOfInstances({&trial, 1});
    for (const FailureRow& row : FailureTable()) {
      if (row.failure == FailureReason::kNone) continue;
      EXPECT_EQ(attempts[row.failure], row.failure == planted.of_attempt) << row.name;
      EXPECT_EQ(instances[row.failure], row.failure == planted.failure) << row.name;
    }
    // The attempt requested one instance. A displaced instance counts in addition.
    EXPECT_EQ(attempts.asked(), 1);
    EXPECT_EQ(instances.asked(), planted.failure == FailureReason::kNeighborDisplaced ? 2 : 1);
    EXPECT_EQ(trial.outcomes[0].failure, planted.failure);
  }
}

TEST_F(PlantedFailure, EveryReasonIsCovered) {
  const std::vector<Planted> planted = PlantedFailures();
  for (const FailureRow& row : FailureTable()) {
    // A stir is an attempt of its own and is attributed to nothing.
    if (row.failure == FailureReason::kNone || row.failure == FailureReason::kStirred) continue;
    // The trial records these itself (process_estimator_test.cpp).
    if (ProgramFailed(row.failure)) continue;
    EXPECT_TRUE(std::any_of(planted.begin(), planted.end(),
                            [&](const Planted& p) { return p.failure == row.failure; }))
        << row.name << ": plant it above";
  }
}

}  // namespace
}  // namespace pickbed::tests
