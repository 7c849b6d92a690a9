#include "perception/verify/non_maximum_suppression.h"

#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// Two brackets side by side, 10 mm apart.
class TwoBrackets : public ::testing::Test {
 protected:
  TwoBrackets() : object_(ObjectOf(BracketMesh())), models_{MakeModelPoints(*object_)} {
    SyntheticDepth scene(SmallCamera());
    for (const Pose& X : {Left(), Right()}) scene.AddMesh(object_->mesh_O, X);
    cloud_ = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  }
  static Pose Left() { return Translation({-0.035, 0, 0.4}); }
  static Pose Right() { return Translation({0.035, 0, 0.4}); }

  static PoseHypothesis At(const Pose& X_CO, double score) {
    PoseHypothesis h;
    h.X_CO = X_CO;
    h.score = score;
    return h;
  }

  std::shared_ptr<const ObjectModel> object_;
  std::vector<ModelPoints> models_;
  OrganizedCloud cloud_;
};

TEST_F(TwoBrackets, NeighborIsKeptAndDuplicateIsRemoved) {
  const Pose near_left = Perturbed(Left(), {0, 0, 1}, 4, {0.002, 0, 0});
  const auto kept =
      SuppressNonMaxima(cloud_, models_, {At(near_left, 0.6), At(Right(), 0.7), At(Left(), 0.9)});
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].score, 0.9);
  EXPECT_EQ(kept[1].score, 0.7);
}

// The cubes are side by side, so they share few pixels.
TEST(SuppressNonMaxima, PosePenetratingABetterOneIsRemoved) {
  const auto cube = ObjectOf(BoxMesh({0.05, 0.05, 0.05}, Eigen::Vector3d::Zero()));
  const std::vector<ModelPoints> models{MakeModelPoints(*cube)};
  SyntheticDepth scene(SmallCamera());
  const std::vector<double> x_m{-0.03, 0.01, 0.058};  // the second one is 10 mm deep in the first
  for (const double x : x_m) scene.AddMesh(cube->mesh_O, Translation({x, 0, 0.4}));
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  std::vector<PoseHypothesis> all(3);
  for (size_t i = 0; i < 3; ++i) {
    all[i].X_CO = Translation({x_m[i], 0, 0.4});
    all[i].score = 0.9 - 0.1 * static_cast<double>(i);
  }
  NonMaximumSuppressionOptions options;
  options.max_penetration_share = 0.13;  // 11.3 mm
  EXPECT_EQ(SuppressNonMaxima(cloud, models, all, options).size(), 3u);
  options.max_penetration_share = 0.08;  // 6.9 mm
  const auto kept = SuppressNonMaxima(cloud, models, all, options);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].score, all[0].score);
  EXPECT_EQ(kept[1].score, all[2].score);  // near only the one that is suppressed
  EXPECT_EQ(kept[0].suppressed_X_CO.size(), 1u);
}

TEST_F(TwoBrackets, BetterScoreWinsInAnyOrder) {
  const Pose turned = Perturbed(Left(), {0, 0, 1}, 180, Eigen::Vector3d::Zero());
  const auto kept = SuppressNonMaxima(cloud_, models_, {At(Left(), 0.5), At(turned, 0.8)});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].score, 0.8);
}

TEST_F(TwoBrackets, SuppressedPoseIsRecordedAtTheWinner) {
  const Pose near_left = Perturbed(Left(), {0, 0, 1}, 4, {0.002, 0, 0});
  const auto kept =
      SuppressNonMaxima(cloud_, models_, {At(near_left, 0.6), At(Right(), 0.9), At(Left(), 0.7)});
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_TRUE(kept[0].suppressed_X_CO.empty());
  ASSERT_EQ(kept[1].suppressed_X_CO.size(), 1u);
  EXPECT_EQ(kept[1].suppressed_X_CO[0].matrix(), near_left.matrix());
}

TEST_F(TwoBrackets, EqualScoresKeepTheirOrder) {
  PoseHypothesis first = At(Left(), 0.5), second = first;
  second.fit.hidden_share = 1;
  const auto kept = SuppressNonMaxima(cloud_, models_, {first, second});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].fit.hidden_share, 0);
}

TEST_F(TwoBrackets, PoseWithoutPixelsIsRemoved) {
  EXPECT_TRUE(SuppressNonMaxima(cloud_, models_, {At(Translation({0, 0.1, 0.4}), 0.9)}).empty());
  EXPECT_TRUE(SuppressNonMaxima(cloud_, models_, {At(Translation({0, 0, -0.4}), 0.9)}).empty());
  EXPECT_TRUE(SuppressNonMaxima(cloud_, models_, {}).empty());
}

// The first object claims the left and the right place, and the second object claims only the right
// place. If only one instance of the first object is known, its second pose must not suppress the
// second object.
TEST_F(TwoBrackets, SurplusPosesDoNotSuppressOthers) {
  models_.push_back(models_[0]);
  PoseHypothesis other = At(Right(), 0.6);
  other.object = ObjectId{1};
  const std::vector<PoseHypothesis> all{At(Left(), 0.9), At(Right(), 0.8), other};
  const auto unknown = SuppressNonMaxima(cloud_, models_, all);
  ASSERT_EQ(unknown.size(), 2u);
  EXPECT_EQ(unknown[1].object, 0);
  const std::vector<int> one_each{1, 1}, none_of_the_first{0, 1};
  const auto limited = SuppressNonMaxima(cloud_, models_, all, {}, one_each);
  ASSERT_EQ(limited.size(), 2u);
  EXPECT_EQ(limited[0].score, 0.9);
  EXPECT_EQ(limited[1].object, 1);
  const auto others = SuppressNonMaxima(cloud_, models_, all, {}, none_of_the_first);
  ASSERT_EQ(others.size(), 1u);
  EXPECT_EQ(others[0].object, 1);
  EXPECT_THROW(SuppressNonMaxima(cloud_, models_, all, {}, std::vector{1}), InputError);
}

}  // namespace
}  // namespace pickbed::tests
