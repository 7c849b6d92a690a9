#include "eval/blame.h"

#include <gtest/gtest.h>

namespace pickbed {
namespace {

// A tripod of 4 cm legs, part 0 at the origin and part 1 half a metre along x.
class Blame : public ::testing::Test {
 protected:
  Blame() {
    MetricModel tripod;
    tripod.vertices_O = {{0.04, 0, 0}, {0, 0.04, 0}, {0, 0, 0.04}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = 0.0566;
    models_ = {tripod, tripod};
    scene_.objects = {{0, 0, Pose::Identity()}, {1, 1, Translation({0.5, 0, 0})}};
    record_.chosen = 0;
    record_.hypotheses.resize(1);
    record_.outcome.loss = Loss::kSlipped;
  }
  Loss At(const Pose& X_CO) {
    chosen_.X_CO = X_CO;
    return LossOf(record_, chosen_, {scene_, models_, camera_});
  }
  static Pose Wrong() { return Translation({0.03, 0, 0}); }

  std::vector<MetricModel> models_;
  Scene scene_;
  Camera camera_{{640, 480, 600, 600, 319.5, 239.5}, Pose::Identity()};
  PickRecord record_;
  PoseHypothesis chosen_;
};

TEST_F(Blame, NobodyWhenItSucceeded) {
  record_.outcome.success = true;
  EXPECT_EQ(At(Wrong()), Loss::kNone);
}

TEST_F(Blame, BrokenPhysicsWhateverThePose) {
  record_.outcome.loss = Loss::kPhysicsFailed;
  EXPECT_EQ(At(Wrong()), Loss::kPhysicsFailed);
  record_.hypotheses[0].correct = true;
  EXPECT_EQ(At(Pose::Identity()), Loss::kPhysicsFailed);
}

TEST_F(Blame, AnotherPartThatCameIsTheGraspsFaultAtARightPoseAlone) {
  record_.outcome.loss = Loss::kWrongPart;
  EXPECT_EQ(At(Wrong()), Loss::kPoseWrong);
  EXPECT_EQ(At(Translation({0.49, 0, 0})), Loss::kWrongPart);
  record_.hypotheses[0].correct = true;
  EXPECT_EQ(At(Pose::Identity()), Loss::kTookTwo);
}

TEST_F(Blame, EveryLossOfTheHandPassesAtARightPose) {
  record_.hypotheses[0].correct = true;
  for (const Loss loss : {Loss::kCollision, Loss::kClosedOnNothing, Loss::kSlipped, Loss::kDropped,
                          Loss::kMisplaced, Loss::kTookTwo, Loss::kDisturbed}) {
    record_.outcome.loss = loss;
    EXPECT_EQ(At(Pose::Identity()), loss);
  }
}

TEST_F(Blame, PhysicsAtARightPose) {
  record_.hypotheses[0].correct = true;
  EXPECT_EQ(At(Pose::Identity()), Loss::kSlipped);
}

TEST_F(Blame, TheSearchWhenNoStageHadARightPose) {
  EXPECT_EQ(At(Wrong()), Loss::kPoseWrong);
  chosen_.unrefined_X_CO = Wrong();
  chosen_.suppressed_X_CO = {Translation({0, 0.02, 0})};
  EXPECT_EQ(At(Wrong()), Loss::kPoseWrong);
}

TEST_F(Blame, TheRefinerWhenItLeftARightPose) {
  chosen_.unrefined_X_CO = Translation({0.001, 0, 0});
  chosen_.suppressed_X_CO = {Pose::Identity()};
  EXPECT_EQ(At(Wrong()), Loss::kRefinementWorse);
}

TEST_F(Blame, TheSuppressionWhenARightPoseGaveWay) {
  chosen_.suppressed_X_CO = {Translation({0.2, 0, 0}), Translation({0, 0.001, 0})};
  EXPECT_EQ(At(Wrong()), Loss::kSuppressed);
}

TEST_F(Blame, AnotherPartStandsThere) {
  EXPECT_EQ(At(Translation({0.49, 0, 0})), Loss::kWrongPart);
}

TEST_F(Blame, TheCameraIsNotAtTheOrigin) {
  camera_.X_WC = Translation({0, 0, -1});
  chosen_.unrefined_X_CO = Translation({0, 0, 1});
  EXPECT_EQ(At(Translation({0.03, 0, 1})), Loss::kRefinementWorse);
}

// A look without a grasp.
class BlameWithoutGrasp : public Blame {
 protected:
  BlameWithoutGrasp() {
    record_ = {};
    record_.instances = {{0, 0, 0.8, false}, {1, 1, 0.05, false}};
  }
  Loss Without(const std::vector<PoseHypothesis>& hypotheses, bool correct = false) {
    record_.hypotheses.assign(hypotheses.size(), {});
    if (correct) record_.hypotheses.back().correct = true;
    return LossWithoutGrasp(record_, hypotheses, {scene_, models_, camera_});
  }
};

TEST_F(BlameWithoutGrasp, TheEyeWhenNothingIsInViewElseTheSearch) {
  EXPECT_EQ(Without({}), Loss::kNoProposal);
  record_.instances[0].visible_fraction = 0.09;
  EXPECT_EQ(Without({}), Loss::kNotVisible);
}

TEST_F(BlameWithoutGrasp, ThePlannerWhenAPoseIsRightElseTheFirstPosesMaker) {
  PoseHypothesis right, wrong, of_other_kind;
  wrong.X_CO = Wrong();
  of_other_kind.object = 1;
  EXPECT_EQ(Without({wrong, right}, true), Loss::kNoGrasp);
  EXPECT_EQ(Without({wrong}), Loss::kPoseWrong);
  EXPECT_EQ(Without({of_other_kind, wrong}), Loss::kWrongPart);
  wrong.unrefined_X_CO = Pose::Identity();
  EXPECT_EQ(Without({wrong}), Loss::kRefinementWorse);
}

// Part 0 of the look, which no hypothesis recalls.
Loss MissedBy(const std::vector<PoseHypothesis>& hypotheses, const LookTruth& truth,
              double visible = 0.8) {
  LookScore look;
  look.instances = {{0, 0, visible, false}, {1, 1, 0.5, true}};
  const std::vector<Loss> missed = WhyMissed(look, hypotheses, truth);
  EXPECT_EQ(missed.at(1), Loss::kNone) << "a part that is recalled is not missed";
  return missed.at(0);
}

TEST_F(Blame, APartIsMissedForOneReason) {
  const LookTruth truth{scene_, models_, camera_};
  PoseHypothesis own, other, far;
  own.X_CO = Wrong();
  other.object = 1;
  far.object = 1;
  far.X_CO = Translation({0.5, 0, 0});
  EXPECT_EQ(MissedBy({own}, truth, 0.09), Loss::kNotVisible);
  EXPECT_EQ(MissedBy({}, truth), Loss::kNoProposal);
  EXPECT_EQ(MissedBy({far}, truth), Loss::kNoProposal);
  EXPECT_EQ(MissedBy({other}, truth), Loss::kWrongPart);
  EXPECT_EQ(MissedBy({other, own}, truth), Loss::kPoseWrong);
  far.suppressed_X_CO = {Pose::Identity()};
  EXPECT_EQ(MissedBy({far}, truth), Loss::kNoProposal) << "what gave way was of another kind";
  own.suppressed_X_CO = {Translation({0.001, 0, 0})};
  EXPECT_EQ(MissedBy({own}, truth), Loss::kSuppressed);
  own.unrefined_X_CO = Translation({0.001, 0, 0});
  EXPECT_EQ(MissedBy({own}, truth), Loss::kRefinementWorse);
}

}  // namespace
}  // namespace pickbed
