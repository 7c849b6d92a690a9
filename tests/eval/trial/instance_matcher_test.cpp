#include "eval/trial/instance_matcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;

// Objects 0 and 1 are tripods with 4 cm legs. Instances 0 and 1 of object 0 are 2 mm apart,
// instance 2 of object 1 is beside them and instance 3 of object 0 is far away.
class InstanceMatcherTest : public ::testing::Test {
 protected:
  InstanceMatcherTest() {
    MetricModel tripod;
    tripod.vertices_O = {{0.04, 0, 0}, {0, 0.04, 0}, {0, 0, 0.04}};
    tripod.symmetries_O = {Pose::Identity()};
    tripod.diameter_m = 0.05;
    models_ = {tripod, tripod};
    Scene scene;
    scene.objects = {{InstanceId{7}, ObjectId{0}, At(0)},
                     {InstanceId{8}, ObjectId{0}, At(0.002)},
                     {InstanceId{9}, ObjectId{1}, At(0.010)},
                     {InstanceId{5}, ObjectId{0}, At(0.5)}};
    matcher_.emplace(models_, InstancesOf(scene, {1, 0.5, 0.25, 0}, At(0, 1)));
  }
  static Pose At(double x_m, double z_m = 0) { return Translation({x_m, 0, z_m}); }

  std::vector<MetricModel> models_;
  std::optional<InstanceMatcher> matcher_;
};

TEST_F(InstanceMatcherTest, InstancesAreInTheCameraFrame) {
  const TrueInstance& last = matcher_->instances().at(3);
  EXPECT_EQ(last.instance, 5);
  EXPECT_EQ(last.visible_fraction, 0);
  EXPECT_TRUE(last.X_CO.isApprox(At(0.5, 1)));
}

TEST_F(InstanceMatcherTest, MatchesAreByDistanceAndOfTheSameObject) {
  EXPECT_THAT(matcher_->ByDistance(ObjectId{0}, At(0.0015, 1)),
              ElementsAre(Field(&InstanceMatch::position, 1), Field(&InstanceMatch::position, 0)));
  const InstanceMatch nearest = matcher_->Nearest(ObjectId{0}, At(0.010, 1));
  EXPECT_EQ(nearest.position, 1);
  EXPECT_NEAR(nearest.mssd_m, 0.008, 1e-12);
  EXPECT_NEAR(nearest.mssd_diameters, 0.16, 1e-9);
  EXPECT_FALSE(nearest.correct);
  matcher_.emplace(models_, std::vector<TrueInstance>());
  EXPECT_EQ(matcher_->Nearest(ObjectId{0}, At(0, 1)).position, -1);
}

TEST_F(InstanceMatcherTest, CorrectMeansATenthOfTheDiameterAndTheSameObject) {
  EXPECT_TRUE(matcher_->IsCorrectFor(0, ObjectId{0}, At(0.0049, 1)));
  EXPECT_FALSE(matcher_->IsCorrectFor(0, ObjectId{0}, At(0.0051, 1)));
  EXPECT_FALSE(matcher_->IsCorrectFor(0, ObjectId{1}, At(0, 1)));
  EXPECT_TRUE(matcher_->IsCorrect(ObjectId{1}, At(0.012, 1)));
  EXPECT_FALSE(matcher_->IsCorrect(ObjectId{1}, At(0.002, 1)));
}

TEST_F(InstanceMatcherTest, TakenInstancesAreSkipped) {
  const auto matches = matcher_->ByDistance(ObjectId{0}, At(0.0015, 1));
  EXPECT_EQ(FirstFreeCorrect(matches, {false, false, false, false}), 1);
  EXPECT_EQ(FirstFreeCorrect(matches, {false, true, false, false}), 0);
  EXPECT_EQ(FirstFreeCorrect(matches, {true, true, false, false}), -1);
  const Pose beside = At(0.010, 1);
  EXPECT_EQ(matcher_->NearestFree(ObjectId{0}, beside, 0.025, {false, false, false, false}), 1);
  EXPECT_EQ(matcher_->NearestFree(ObjectId{0}, beside, 0.025, {false, true, false, false}), 0);
  EXPECT_EQ(matcher_->NearestFree(ObjectId{0}, beside, 0.009, {false, true, false, false}), -1);
}

TEST_F(InstanceMatcherTest, NearestOfAnyObjectMayHaveAnotherObject) {
  EXPECT_EQ(matcher_->NearestOfAnyObject(ObjectId{0}, At(0.009, 1)), 2);
}

}  // namespace
}  // namespace pickbed::tests
