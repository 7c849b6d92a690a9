// Votes that are absent, equal, or far away, for objects without extent and kernels without radius.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "perception/voting/pose_clustering.h"
#include "perception/voting/vote_density.h"
#include "perception/voting/vote_modes.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::HasSubstr;

// A plate without thickness.
std::shared_ptr<const ObjectModel> PlateObject() {
  return ObjectOf(MeshOf({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, {{0, 1, 2}, {0, 2, 1}}));
}

double DensityOfVotes(const ObjectModel& object, const std::vector<PoseVote>& votes,
                      const Pose& X_CO) {
  const PoseEmbedding embedding(object);
  VoteDensity::Scratch scratch;
  return VoteDensity(embedding, object.mass.com_O, object.diameter_m, 0.1, votes)
      .Around(X_CO, kNoPatch, scratch);
}

TEST(DegenerateDensity, EqualVotesCountOneEach) {
  for (const auto& object : {ObjectOf(BracketMesh()), PlateObject()}) {
    EXPECT_EQ(DensityOfVotes(*object, {}, BracketPose()), 0);
    for (const size_t count : {1, 7, 8, 9, 100}) {
      const std::vector<PoseVote> votes(count, {BracketPose(), 3});
      EXPECT_NEAR(DensityOfVotes(*object, votes, BracketPose()), static_cast<double>(count), 1e-3);
      EXPECT_EQ(DensityOfVotes(*object, votes, Translation({0, 0, -1})), 0);
    }
  }
}

TEST(DegenerateDensity, FarVotesCountOnlyWhereTheyAre) {
  const auto object = PlateObject();
  for (const double far_m : {1e3, 1e12, 1e30}) {
    const std::vector<PoseVote> votes{{Translation({0, 0, 0.5}), 0},
                                      {Translation({0, far_m, 0}), 1}};
    EXPECT_NEAR(DensityOfVotes(*object, votes, Translation({0, 0, 0.5})), 1, 1e-3) << far_m;
    EXPECT_EQ(DensityOfVotes(*object, votes, Translation({0, 1, 0.5})), 0) << far_m;
  }
}

std::vector<RawHypothesis> EqualVotes(size_t count, const Pose& X_CO) {
  RawHypothesis vote;
  vote.X_CO = X_CO;
  return std::vector<RawHypothesis>(count, vote);
}

TEST(DegenerateClusters, WithoutRadiusOnlyEqualPosesMerge) {
  for (const auto& object : {ObjectOf(BracketMesh()), PlateObject()}) {
    const std::vector<PoseDistance> distances = {PoseDistance(*object)};
    for (const double far_m : {1e-3, 1.0, 1e30}) {
      std::vector<RawHypothesis> votes = EqualVotes(20, BracketPose());
      for (const RawHypothesis& vote : EqualVotes(10, Translation({far_m, 0, 1}))) {
        votes.push_back(vote);
      }
      const auto clusters = ClusterVotes(votes, distances, 0, 100);
      ASSERT_EQ(clusters.size(), 2u) << far_m;
      EXPECT_EQ(clusters[0].votes, 20) << far_m;
      EXPECT_EQ(clusters[1].votes, 10) << far_m;
    }
    EXPECT_TRUE(ClusterVotes(EqualVotes(20, BracketPose()), distances, 0.1, 0).empty());
  }
}

TEST(DegenerateMeanRotation, IsAUnitQuaternion) {
  const Quaterniond x(Eigen::AngleAxisd(0.5, Vector3d::UnitX()));
  const Quaterniond opposite(-x.coeffs());
  const Quaterniond half_x(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  const Quaterniond half_y(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitY()));
  EXPECT_THROW(MeanRotation({}, {}), std::logic_error);
  for (const std::vector<Quaterniond>& equal :
       {std::vector<Quaterniond>{x}, {x, x, x}, {x, opposite}, {opposite, opposite}}) {
    const std::vector<double> weights(equal.size(), 0.5);
    EXPECT_NEAR(MeanRotation(equal, weights).angularDistance(x), 0, 1e-6);
  }
  // No rotation is nearer to both than others, or nothing has a weight.
  const std::vector<Quaterniond> apart{half_x, half_y, Quaterniond::Identity()};
  for (const double weight : {0.0, 1e-300, 1.0}) {
    const Quaterniond mean = MeanRotation(apart, std::vector<double>(3, weight));
    EXPECT_NEAR(mean.norm(), 1, 1e-9) << weight;
  }
}

TEST(DegenerateRotations, NearestIsOneOfTheSymmetricRotations) {
  const Vector3d z = Vector3d::UnitZ(), zero = Vector3d::Zero();
  const SymmetrySet none, axis_twice{{}, {{z, zero}, {z, zero}}},
      same{{Pose::Identity(), Pose::Identity()}, {}};
  const Quaterniond q(Eigen::AngleAxisd(1.3, Vector3d(1, 2, 3).normalized()));
  const Quaterniond opposite(-q.coeffs());
  for (const SymmetrySet& set : {none, axis_twice, same}) {
    const ObjectRotations rotations(set);
    EXPECT_NEAR(rotations.Angle(q, q), 0, 1e-7);
    EXPECT_NEAR(rotations.Angle(q, opposite), 0, 1e-7);
    EXPECT_GT(rotations.Nearest(q, opposite).dot(opposite), 0.999);
  }
}

std::vector<VoteMode> ModesOf(const ObjectModel& object, const std::vector<CastVote>& votes,
                              double min_weight = 1) {
  ModeOptions options;
  options.min_weight = min_weight;
  return FindVoteModes(object, ObjectRotations({}), votes, options);
}

TEST(DegenerateModes, EqualVotesAreOneMode) {
  for (const auto& object : {ObjectOf(BracketMesh()), PlateObject()}) {
    EXPECT_TRUE(ModesOf(*object, {}).empty());
    EXPECT_TRUE(ModesOf(*object, {}, 0).empty());
    for (const int count : {1, 2, 50}) {
      const auto modes = ModesOf(*object, std::vector<CastVote>(count, {BracketPose(), 0}));
      ASSERT_EQ(modes.size(), 1u);
      EXPECT_EQ(modes[0].votes, count);
      EXPECT_NEAR(modes[0].weight, count, 1e-9);
      EXPECT_LT((modes[0].X_CO.matrix() - BracketPose().matrix()).norm(), 1e-6);
    }
  }
}

TEST(DegenerateModes, VotesWithoutADistanceAreIgnored) {
  const auto object = ObjectOf(BracketMesh());
  std::vector<CastVote> votes(5, {BracketPose(), 0});
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30f}) {
    EXPECT_TRUE(ModesOf(*object, std::vector<CastVote>(5, {BracketPose(), bad}), 0).empty()) << bad;
    votes.insert(votes.begin() + 2, {Translation({0, 0, 0.4}), bad});
    const auto modes = ModesOf(*object, votes, 0);
    ASSERT_EQ(modes.size(), 1u) << bad;
    EXPECT_EQ(modes[0].votes, 5) << bad;
  }
}

TEST(DegenerateModes, FarVotesAreModesOfTheirOwn) {
  const auto object = PlateObject();
  for (const double far_m : {1e3, 1e12, 1e30}) {
    std::vector<CastVote> votes(5, {Translation({0, 0, 0.4}), 0});
    votes.push_back({Translation({far_m, -far_m, 0}), 0});
    votes.push_back({Translation({-far_m, 0, far_m}), 0});
    const auto modes = ModesOf(*object, votes);
    ASSERT_EQ(modes.size(), 3u) << far_m;
    EXPECT_EQ(modes[0].votes, 5) << far_m;
  }
}

TEST(DegenerateModes, ObjectsWithoutADiameterAreRefused) {
  const auto point = ObjectOf(MeshOf({{0, 0, 0}}, {{0, 0, 0}}));
  EXPECT_THAT(ErrorOf([&] {
                ModesOf(*point, {{Translation({0, 0, 0.4}), 0}});
              }),
              HasSubstr("has no diameter"));
}

}  // namespace
}  // namespace pickbed::tests
