#include "eval/trial/pose_matching.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// A box of 2 x 3 x 5 cm. If symmetric, a half turn about z maps it onto itself.
MetricModel Box(bool symmetric) {
  MetricModel model;
  for (int corner = 0; corner < 8; ++corner) {
    model.vertices_O.emplace_back(corner & 1 ? 0.01 : -0.01, corner & 2 ? 0.015 : -0.015,
                                  corner & 4 ? 0.025 : -0.025);
  }
  model.symmetries_O = {Pose::Identity()};
  if (symmetric) {
    Pose half_turn = Pose::Identity();
    half_turn.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    model.symmetries_O.push_back(half_turn);
  }
  model.diameter_m = 2 * Eigen::Vector3d(0.01, 0.015, 0.025).norm();
  return model;
}

struct MatchingCase {
  Scene scene;
  Camera camera;
  std::vector<double> visible;
  std::vector<PoseHypothesis> hypotheses;

  void AddInstance(InstanceId instance, ObjectId object, const Pose& X_WO) {
    scene.objects.push_back({instance, object, X_WO});
    visible.push_back(0.5);
  }
  void AddHypothesis(ObjectId object, const Pose& X_WO, double score) {
    hypotheses.push_back({object, camera.X_CW() * X_WO, score, {}});
  }
  AttemptScore Score(const std::vector<MetricModel>& models) const {
    return ScoreAgainstTruth({models, InstancesOf(scene, visible, camera.X_CW())}, camera,
                             hypotheses);
  }
};

MatchingCase EmptyCase() {
  MatchingCase matching;
  matching.camera.SetPose(LookAt({0.1, -0.2, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
  return matching;
}

Pose At(double x, double y = 0, double z = 0) { return Translation({x, y, z}); }

TEST(PoseMatching, StoresThePoseInWorldAndInTheTrueObjectFrame) {
  MatchingCase matching = EmptyCase();
  const Pose X_WO = At(0.1, 0.05, 0.02) * Pose(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ()));
  const Pose error =
      At(0.001, -0.002, 0.003) * Pose(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  matching.AddInstance(InstanceId{7}, ObjectId{0}, X_WO);
  matching.AddHypothesis(ObjectId{0}, X_WO * error, 0.4);
  const HypothesisRecord score = matching.Score({Box(false)}).hypotheses[0].record;
  EXPECT_TRUE(score.X_WO.isApprox(X_WO * error, 1e-9));
  EXPECT_TRUE(score.X_OE.isApprox(error, 1e-9));
}

TEST(PoseMatching, GroundTruthPosesAreCorrectWithZeroError) {
  MatchingCase matching = EmptyCase();
  matching.AddInstance(InstanceId{7}, ObjectId{0}, At(0.1));
  matching.AddInstance(InstanceId{3}, ObjectId{0}, At(-0.1));
  matching.AddHypothesis(ObjectId{0}, At(-0.1), 0.4);
  matching.AddHypothesis(ObjectId{0}, At(0.1), 0.9);
  const AttemptScore score = matching.Score({Box(false)});
  ASSERT_EQ(score.hypotheses.size(), 2u);
  EXPECT_EQ(score.hypotheses[0].record.instance, 3);
  EXPECT_EQ(score.hypotheses[1].record.instance, 7);
  for (const HypothesisRecord& h : score.Records()) {
    EXPECT_TRUE(h.correct);
    EXPECT_NEAR(h.mssd_m(), 0, 1e-12);
    EXPECT_NEAR(h.translation_m(), 0, 1e-12);
  }
  for (const InstanceRecord& instance : score.instances) EXPECT_TRUE(instance.recalled);
}

TEST(PoseMatching, TwoHypothesesOnOneInstanceRecallOneInstance) {
  MatchingCase matching = EmptyCase();
  matching.AddInstance(InstanceId{0}, ObjectId{0}, At(0));
  matching.AddInstance(InstanceId{1}, ObjectId{0}, At(0.2));
  matching.AddHypothesis(ObjectId{0}, At(0.0005), 0.9);
  matching.AddHypothesis(ObjectId{0}, At(0), 0.8);
  const AttemptScore score = matching.Score({Box(false)});
  EXPECT_TRUE(score.hypotheses[0].record.correct);
  EXPECT_TRUE(score.hypotheses[1].record.correct);
  EXPECT_TRUE(score.instances[0].recalled);
  EXPECT_FALSE(score.instances[1].recalled);
}

TEST(PoseMatching, SecondHypothesisRecallsTheNextInstanceWithinReach) {
  // The instances are closer together than a tenth of the diameter. Both hypotheses are nearest to
  // instance 0.
  const MetricModel box = Box(false);
  const double reach_m = kCorrectDiameters * box.diameter_m;
  MatchingCase matching = EmptyCase();
  matching.AddInstance(InstanceId{0}, ObjectId{0}, At(0));
  matching.AddInstance(InstanceId{1}, ObjectId{0}, At(0.6 * reach_m));
  matching.AddHypothesis(ObjectId{0}, At(0.1 * reach_m), 0.9);
  matching.AddHypothesis(ObjectId{0}, At(-0.1 * reach_m), 0.8);
  const AttemptScore score = matching.Score({box});
  EXPECT_EQ(score.hypotheses[1].record.instance, 0);
  EXPECT_TRUE(score.instances[0].recalled);
  EXPECT_TRUE(score.instances[1].recalled);
}

TEST(PoseMatching, CorrectnessThresholdIsATenthOfTheDiameter) {
  const MetricModel box = Box(false);
  for (const auto& [share, correct] : {std::pair{0.099, true}, std::pair{0.101, false}}) {
    MatchingCase matching = EmptyCase();
    matching.AddInstance(InstanceId{0}, ObjectId{0}, At(0));
    matching.AddHypothesis(ObjectId{0}, At(share * box.diameter_m), 1);
    const AttemptScore score = matching.Score({box});
    EXPECT_EQ(score.hypotheses[0].record.correct, correct) << share;
    EXPECT_EQ(score.instances[0].recalled, correct) << share;
    EXPECT_NEAR(score.hypotheses[0].record.mssd_diameters(), share, 1e-9);
  }
}

TEST(PoseMatching, AnotherObjectAtTheSamePoseIsNoMatch) {
  MatchingCase matching = EmptyCase();
  matching.AddInstance(InstanceId{0}, ObjectId{1}, At(0));
  matching.AddHypothesis(ObjectId{0}, At(0), 0.9);
  const AttemptScore score = matching.Score({Box(false), Box(false)});
  EXPECT_EQ(score.hypotheses[0].record.instance, -1);
  EXPECT_FALSE(score.hypotheses[0].record.correct);
  EXPECT_TRUE(std::isinf(score.hypotheses[0].record.mssd_m()));
  EXPECT_FALSE(score.instances[0].recalled);
}

TEST(PoseMatching, RotationBySymmetryIsNoError) {
  Pose rotated = At(0.05);
  rotated.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (bool symmetric : {false, true}) {
    MatchingCase matching = EmptyCase();
    matching.AddInstance(InstanceId{0}, ObjectId{0}, At(0.05));
    matching.AddHypothesis(ObjectId{0}, rotated, 1);
    EXPECT_EQ(matching.Score({Box(symmetric)}).hypotheses[0].record.correct, symmetric);
  }
}

TEST(PoseMatching, NearestInstanceAgreesWithExhaustiveSearch) {
  Rng rng(3);
  MetricModel model = Box(true);
  for (Eigen::Vector3d& vertex : model.vertices_O) vertex += Eigen::Vector3d(0.02, 0.01, 0);
  for (int round = 0; round < 50; ++round) {
    MatchingCase matching = EmptyCase();
    const auto random_pose = [&] {
      return MakePose(rng.Rotation().toRotationMatrix(), 0.05 * rng.UnitVector());
    };
    for (int i = 0; i < 12; ++i) matching.AddInstance(InstanceId(i), ObjectId{0}, random_pose());
    const Pose estimated = random_pose();
    matching.AddHypothesis(ObjectId{0}, estimated, 1);
    int nearest = -1;
    double min_m = 1e9;
    for (const PosedObject& posed : matching.scene.objects) {
      const double mssd_m = Mssd(model, estimated, posed.X_WO);
      if (mssd_m < min_m) {
        min_m = mssd_m;
        nearest = posed.instance;
      }
    }
    const HypothesisRecord score = matching.Score({model}).hypotheses[0].record;
    EXPECT_EQ(score.instance, nearest);
    EXPECT_NEAR(score.mssd_m(), min_m, 1e-12);
  }
}

}  // namespace
}  // namespace pickbed::tests
