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

TEST_F(Blame, BrokenPhysicsAndPartsOfAnotherKindWhateverThePose) {
  for (const Loss loss : {Loss::kPhysicsFailed, Loss::kWrongPart}) {
    record_.outcome.loss = loss;
    EXPECT_EQ(At(Wrong()), loss);
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

}  // namespace
}  // namespace pickbed
