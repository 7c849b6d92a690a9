#include "eval/trial/failure_attribution.h"

#include <gtest/gtest.h>

#include "eval/trial/stage_oracle.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Two tripod objects with 4 cm legs: instance 0 at the origin and instance 1 at x = 0.5 m.
class FailureAttribution : public ::testing::Test {
 protected:
  FailureAttribution() {
    MetricModel tripod;
    tripod.vertices_O = {{0.04, 0, 0}, {0, 0.04, 0}, {InstanceId{0}, ObjectId{0}, 0.04}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = 0.0566;
    models_ = {tripod, tripod};
    scene_.objects = {{InstanceId{0}, ObjectId{0}, Pose::Identity()},
                      {InstanceId{1}, ObjectId{1}, Translation({0.5, 0, 0})}};
    record_.grasp = Grasp();
    record_.chosen = 0;
    record_.hypotheses.resize(1);
    record_.outcome.failure = FailureReason::kSlipped;
  }
  FailureReason At(const Pose& X_CO) {
    chosen_.X_CO = X_CO;
    const InstanceMatcher truth = Truth();
    return AttributeFailure(record_, Joined({chosen_}, truth), kMatchDiameters, truth);
  }
  InstanceMatcher Truth() const {
    return {models_, InstancesOf(scene_, {0.8, 0.05}, camera_.X_CW())};
  }
  // Joins the hypotheses with the records of the attempt.
  std::vector<ScoredHypothesis> Joined(const std::vector<PoseHypothesis>& hypotheses,
                                       const InstanceMatcher& truth) const {
    std::vector<ScoredHypothesis> joined;
    for (const PoseHypothesis& h : hypotheses) {
      joined.push_back({h, record_.hypotheses.at(joined.size()), -1,
                        truth.NearestOfAnyObject(h.object, h.X_CO)});
    }
    return joined;
  }
  static Pose Wrong() { return Translation({0.03, 0, 0}); }

  std::vector<MetricModel> models_;
  Scene scene_;
  Camera camera_{{640, 480, 600, 600, 319.5, 239.5}, Pose::Identity()};
  AttemptRecord record_;
  PoseHypothesis chosen_;
};

TEST_F(FailureAttribution, NoReasonOnSuccess) {
  record_.outcome.success = true;
  EXPECT_EQ(At(Wrong()), FailureReason::kNone);
}

TEST_F(FailureAttribution, PhysicsFailureIsKeptAtAnyPose) {
  record_.outcome.failure = FailureReason::kPhysicsFailed;
  EXPECT_EQ(At(Wrong()), FailureReason::kPhysicsFailed);
  record_.hypotheses[0].correct = true;
  EXPECT_EQ(At(Pose::Identity()), FailureReason::kPhysicsFailed);
}

TEST_F(FailureAttribution, WrongLiftedInstanceIsDoublePickOnlyAtACorrectPose) {
  record_.outcome.failure = FailureReason::kWrongObject;
  EXPECT_EQ(At(Wrong()), FailureReason::kPoseWrong);
  EXPECT_EQ(At(Translation({0.49, 0, 0})), FailureReason::kWrongObject);
  record_.hypotheses[0].correct = true;
  EXPECT_EQ(At(Pose::Identity()), FailureReason::kDoublePick);
}

TEST_F(FailureAttribution, GraspFailuresAreKeptAtACorrectPose) {
  record_.hypotheses[0].correct = true;
  for (const FailureReason failure :
       {FailureReason::kCollision, FailureReason::kClosedOnNothing, FailureReason::kSlipped,
        FailureReason::kDropped, FailureReason::kMisplaced, FailureReason::kDoublePick,
        FailureReason::kNeighborDisplaced, FailureReason::kEntangled}) {
    record_.outcome.failure = failure;
    EXPECT_EQ(At(Pose::Identity()), failure);
  }
}

TEST_F(FailureAttribution, SlipIsKeptAtACorrectPose) {
  record_.hypotheses[0].correct = true;
  EXPECT_EQ(At(Pose::Identity()), FailureReason::kSlipped);
}

TEST_F(FailureAttribution, WrongPoseWhenNoStageHadACorrectPose) {
  EXPECT_EQ(At(Wrong()), FailureReason::kPoseWrong);
  chosen_.unrefined_X_CO = Wrong();
  chosen_.suppressed_X_CO = {Translation({0, 0.02, 0})};
  EXPECT_EQ(At(Wrong()), FailureReason::kPoseWrong);
}

TEST_F(FailureAttribution, RefinementWhenItWorsenedACorrectPose) {
  chosen_.unrefined_X_CO = Translation({0.001, 0, 0});
  chosen_.suppressed_X_CO = {Pose::Identity()};
  EXPECT_EQ(At(Wrong()), FailureReason::kRefinementWorse);
}

TEST_F(FailureAttribution, SuppressionWhenItRemovedACorrectPose) {
  chosen_.suppressed_X_CO = {Translation({0.2, 0, 0}), Translation({0, 0.001, 0})};
  EXPECT_EQ(At(Wrong()), FailureReason::kSuppressed);
}

TEST_F(FailureAttribution, WrongObjectWhenAnotherObjectIsAtThePose) {
  EXPECT_EQ(At(Translation({0.49, 0, 0})), FailureReason::kWrongObject);
}

TEST_F(FailureAttribution, CameraPoseIsAppliedToHypotheses) {
  camera_.SetPose(Translation({0, 0, -1}));
  chosen_.unrefined_X_CO = Translation({0, 0, 1});
  EXPECT_EQ(At(Translation({0.03, 0, 1})), FailureReason::kRefinementWorse);
}

// An attempt without a grasp.
class FailureAttributionWithoutGrasp : public FailureAttribution {
 protected:
  FailureAttributionWithoutGrasp() {
    record_ = {};
    record_.instances = {{InstanceId{0}, ObjectId{0}, 0.8, false},
                         {InstanceId{1}, ObjectId{1}, 0.05, false}};
  }
  FailureReason Without(const std::vector<PoseHypothesis>& hypotheses, bool correct = false) {
    record_.hypotheses.assign(hypotheses.size(), {});
    if (correct) record_.hypotheses.back().correct = true;
    const InstanceMatcher truth = Truth();
    return AttributeFailure(record_, Joined(hypotheses, truth), kMatchDiameters, truth);
  }
};

TEST_F(FailureAttributionWithoutGrasp, NotVisibleWhenAllInstancesAreBelowTenPercent) {
  EXPECT_EQ(Without({}), FailureReason::kNoProposal);
  record_.instances[0].visible_fraction = 0.09;
  EXPECT_EQ(Without({}), FailureReason::kNotVisible);
}

TEST_F(FailureAttributionWithoutGrasp, NoGraspIfAPoseIsCorrectElseReasonOfTheFirstPose) {
  PoseHypothesis right, wrong, of_other_object;
  wrong.X_CO = Wrong();
  of_other_object.object = ObjectId{1};
  EXPECT_EQ(Without({wrong, right}, true), FailureReason::kNoGrasp);
  EXPECT_EQ(Without({wrong}), FailureReason::kPoseWrong);
  EXPECT_EQ(Without({of_other_object, wrong}), FailureReason::kWrongObject);
  wrong.unrefined_X_CO = Pose::Identity();
  EXPECT_EQ(Without({wrong}), FailureReason::kRefinementWorse);
}

// Returns the reason why instance 0 is missed. No hypothesis recalls it; instance 1 is recalled.
FailureReason MissedBy(const std::vector<PoseHypothesis>& hypotheses, const InstanceMatcher& truth,
                       double visible = 0.8) {
  AttemptScore score;
  score.instances = {{InstanceId{0}, ObjectId{0}, visible, false},
                     {InstanceId{1}, ObjectId{1}, 0.5, true}};
  for (const PoseHypothesis& h : hypotheses) {
    score.hypotheses.push_back({h, {}, -1, truth.NearestOfAnyObject(h.object, h.X_CO)});
  }
  const std::vector<FailureReason> missed = MissReasons(score, truth);
  EXPECT_EQ(missed.at(1), FailureReason::kNone) << "a recalled instance has no reason";
  return missed.at(0);
}

TEST_F(FailureAttribution, MissedInstanceHasOneReason) {
  const InstanceMatcher truth = Truth();
  PoseHypothesis own, other, far;
  own.X_CO = Wrong();
  other.object = ObjectId{1};
  far.object = ObjectId{1};
  far.X_CO = Translation({0.5, 0, 0});
  EXPECT_EQ(MissedBy({own}, truth, 0.09), FailureReason::kNotVisible);
  EXPECT_EQ(MissedBy({}, truth), FailureReason::kNoProposal);
  EXPECT_EQ(MissedBy({far}, truth), FailureReason::kNoProposal);
  EXPECT_EQ(MissedBy({other}, truth), FailureReason::kWrongObject);
  EXPECT_EQ(MissedBy({other, own}, truth), FailureReason::kPoseWrong);
  far.suppressed_X_CO = {Pose::Identity()};
  EXPECT_EQ(MissedBy({far}, truth), FailureReason::kNoProposal)
      << "the suppressed pose belongs to another object";
  own.suppressed_X_CO = {Translation({0.001, 0, 0})};
  EXPECT_EQ(MissedBy({own}, truth), FailureReason::kSuppressed);
  own.unrefined_X_CO = Translation({0.001, 0, 0});
  EXPECT_EQ(MissedBy({own}, truth), FailureReason::kRefinementWorse);
}

}  // namespace
}  // namespace pickbed::tests
