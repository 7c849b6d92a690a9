#include "eval/trial/stage_oracle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

// Two tripod objects with 4 cm legs: instances 0 and 1 of object 0, instance 2 of object 1, far
// apart.
class StageOracleTest : public ::testing::Test {
 protected:
  StageOracleTest() {
    MetricModel tripod;
    tripod.vertices_O = {{0.04, 0, 0}, {0, 0.04, 0}, {InstanceId{0}, ObjectId{0}, 0.04}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = 0.0566;
    models_ = {tripod, tripod};
    instances_ = {
        {ObjectId{0}, At(0), 0.9}, {ObjectId{0}, At(0.5), 0.6}, {ObjectId{1}, At(1), 0.2}};
  }
  static Pose At(double x_m, double y_m = 0) { return Translation({x_m, y_m, 1}); }
  static PoseHypothesis Hypothesis(ObjectId object, const Pose& X_CO, double score) {
    PoseHypothesis h;
    h.object = object;
    h.X_CO = X_CO;
    h.score = score;
    return h;
  }
  std::vector<PoseHypothesis> Substitute(const std::vector<PoseHypothesis>& estimated,
                                         const OracleStages& truth) const {
    return SubstituteTruth(estimated, {models_, instances_}, truth);
  }

  std::vector<MetricModel> models_;
  std::vector<TrueInstance> instances_;
};

// Pose error of more than a tenth and less than half of the diameter.
constexpr double kOff_m = 0.015;

TEST_F(StageOracleTest, WithoutSubstitutionNothingChanges) {
  const auto poses = Substitute(
      {Hypothesis(ObjectId{0}, At(0.2), 0.9), Hypothesis(ObjectId{1}, At(1, kOff_m), 0.4)}, {});
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_TRUE(poses[0].X_CO.isApprox(At(0.2)));
  EXPECT_TRUE(poses[1].X_CO.isApprox(At(1, kOff_m)));
}

TEST_F(StageOracleTest, DetectionRemovesFalseAndAddsMissedInstances) {
  // A wrong pose, its duplicate, a pose on no instance, and a pose with the wrong object.
  const auto poses = Substitute(
      {Hypothesis(ObjectId{0}, At(0, kOff_m), 0.9), Hypothesis(ObjectId{0}, At(0, -kOff_m), 0.8),
       Hypothesis(ObjectId{0}, At(0.25), 0.7), Hypothesis(ObjectId{0}, At(1), 0.6)},
      {.detection = true});
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_TRUE(poses[0].X_CO.isApprox(At(0, kOff_m))) << "detection does not correct a pose";
  EXPECT_TRUE(poses[1].X_CO.isApprox(At(0.5)));
  EXPECT_EQ(poses[1].object, 0);
  EXPECT_DOUBLE_EQ(poses[1].score, 0.8);
  EXPECT_TRUE(poses[2].X_CO.isApprox(At(1)));
  EXPECT_EQ(poses[2].object, 1);
  EXPECT_DOUBLE_EQ(poses[2].score, 0.6);
}

TEST_F(StageOracleTest, PoseCorrectsPosesOnInstancesAndAddsNone) {
  PoseHypothesis off = Hypothesis(ObjectId{0}, At(0, kOff_m), 0.9);
  off.suppressed_X_CO = {At(0)};
  off.unrefined_X_CO = At(0);
  const auto poses = Substitute(
      {off, Hypothesis(ObjectId{0}, At(0.25), 0.7), Hypothesis(ObjectId{1}, At(0.5), 0.6)},
      {.pose = true});
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_TRUE(poses[0].X_CO.isApprox(At(0)));
  EXPECT_FALSE(poses[0].unrefined_X_CO.has_value());
  EXPECT_TRUE(poses[0].suppressed_X_CO.empty());
  EXPECT_TRUE(poses[1].X_CO.isApprox(At(0.25))) << "it is on no instance";
  EXPECT_TRUE(poses[2].X_CO.isApprox(At(0.5))) << "it is on an instance of another object";
}

TEST_F(StageOracleTest, RefinementCorrectsOnlyPosesThatWereOnceCorrect) {
  PoseHypothesis undone = Hypothesis(ObjectId{0}, At(0, kOff_m), 0.9);
  undone.unrefined_X_CO = At(0, 0.001);
  PoseHypothesis suppressing = Hypothesis(ObjectId{1}, At(1, kOff_m), 0.8);
  suppressing.suppressed_X_CO = {At(0.7), At(1, 0.002)};
  PoseHypothesis never = Hypothesis(ObjectId{0}, At(0.5, kOff_m), 0.7);
  never.unrefined_X_CO = At(0.5, 1.2 * kOff_m);
  auto poses = Substitute({undone, suppressing, never}, {.refinement = true});
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_TRUE(poses[0].X_CO.isApprox(At(0)));
  EXPECT_TRUE(poses[1].X_CO.isApprox(At(1)));
  EXPECT_TRUE(poses[2].X_CO.isApprox(At(0.5, kOff_m)));
  EXPECT_TRUE(poses[2].unrefined_X_CO.has_value());
  poses = Substitute({Hypothesis(ObjectId{0}, At(0, 0.002), 0.9)}, {.refinement = true});
  EXPECT_EQ(poses[0].X_CO.matrix(), At(0).matrix()) << "a correct pose becomes exact";
}

TEST_F(StageOracleTest, PerceptionReturnsTheGroundTruth) {
  const auto poses = Substitute({}, OracleNamed("perception").truth);
  ASSERT_EQ(poses.size(), instances_.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].object, instances_[i].object);
    EXPECT_EQ(poses[i].X_CO.matrix(), instances_[i].X_CO.matrix());
  }
}

TEST(OracleTable, HasEachStageAndTheirCombinations) {
  EXPECT_EQ(OracleNamed("detection").truth, (OracleStages{.detection = true}));
  EXPECT_EQ(OracleNamed("pose").truth, (OracleStages{.pose = true}));
  EXPECT_EQ(OracleNamed("refinement").truth, (OracleStages{.refinement = true}));
  EXPECT_EQ(OracleNamed("grasp").truth, (OracleStages{.grasp = true}));
  EXPECT_TRUE(OracleNamed("perception").truth.AllOfPerception());
  EXPECT_FALSE(OracleNamed("perception").truth.grasp);
  EXPECT_TRUE(OracleNamed("everything").truth.AllOfPerception());
  EXPECT_TRUE(OracleNamed("everything").truth.grasp);
  EXPECT_THAT(ErrorOf([] { OracleNamed("poes"); }), HasSubstr("did you mean 'pose'?"));
}

}  // namespace
}  // namespace pickbed::tests
