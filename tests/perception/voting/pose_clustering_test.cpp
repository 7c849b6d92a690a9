#include "perception/voting/pose_clustering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

Pose RotationAbout(const Eigen::Vector3d& axis, double angle_rad) {
  return Pose(Eigen::AngleAxisd(angle_rad, axis));
}

Pose RandomPose(Rng& rng, double spread_m) {
  Pose X(rng.Rotation());
  X.translation() =
      Eigen::Vector3d(rng.Uniform(-spread_m, spread_m), rng.Uniform(-spread_m, spread_m),
                      0.8 + rng.Uniform(-spread_m, spread_m));
  return X;
}

TEST(PoseDistance, ShiftDistanceIsLengthOverDiameter) {
  const auto object = ObjectOf(BracketMesh());
  const PoseDistance distance(*object);
  Rng rng(1);
  const Pose X = RandomPose(rng, 0.2);
  const Eigen::Vector3d shift(0.003, -0.004, 0.012);
  EXPECT_NEAR(distance(X, Translation(shift) * X), shift.norm() / object->diameter_m, 1e-12);
  EXPECT_NEAR(distance(X, X), 0, 1e-9);
}

TEST(PoseDistance, DistanceIsSymmetricAndCameraInvariant) {
  const auto object = ObjectOf(BracketMesh());
  const PoseDistance distance(*object);
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Pose A = RandomPose(rng, 0.1), B = RandomPose(rng, 0.1), C = RandomPose(rng, 1);
    EXPECT_NEAR(distance(A, B), distance(B, A), 1e-9);
    EXPECT_NEAR(distance(A, B), distance(C * A, C * B), 1e-9);
  }
}

// A half turn moves the far corner of a box by its diagonal in that plane, unless the half turn is
// a symmetry.
TEST(PoseDistance, DiscreteSymmetryHasZeroDistance) {
  const TriangleMesh box = BoxMesh({0.06, 0.04, 0.02}, Eigen::Vector3d::Zero());
  const Pose half_turn = RotationAbout(Eigen::Vector3d::UnitZ(), std::numbers::pi);
  const auto plain = ObjectOf(box), symmetric = ObjectOf(box, SymmetrySet{{half_turn}, {}});
  Rng rng(3);
  const Pose X = RandomPose(rng, 0.2);
  const double diagonal = std::hypot(0.06, 0.04);
  EXPECT_NEAR(PoseDistance(*plain)(X, X * half_turn), diagonal / plain->diameter_m, 1e-9);
  EXPECT_NEAR(PoseDistance(*symmetric)(X, X * half_turn), 0, 1e-9);
}

TEST(PoseDistance, OnlyTiltOfASymmetryAxisHasDistance) {
  const TriangleMesh disc = BoxMesh({0.06, 0.06, 0.01}, Eigen::Vector3d::Zero());
  const auto object = ObjectOf(disc, SymmetrySet{{}, {ContinuousSymmetry{}}});
  const PoseDistance distance(*object);
  Rng rng(4);
  const Pose X = RandomPose(rng, 0.2);
  EXPECT_NEAR(distance(X, X * RotationAbout(Eigen::Vector3d::UnitZ(), 1.1)), 0, 1e-9);
  const double tilt_rad = 0.3, chord = 2 * std::sin(tilt_rad / 2);
  // The farthest corner is half a diameter from the axis.
  EXPECT_NEAR(distance(X, X * RotationAbout(Eigen::Vector3d::UnitX(), tilt_rad)), 0.5 * chord,
              1e-9);
}

TEST(PoseDistance, BallHasNoOrientation) {
  const TriangleMesh ball = BoxMesh({0.05, 0.05, 0.05}, Eigen::Vector3d::Zero());
  const auto object = ObjectOf(
      ball, SymmetrySet{{},
                        {ContinuousSymmetry{},
                         ContinuousSymmetry{Eigen::Vector3d::UnitX(), Eigen::Vector3d::Zero()}}});
  Rng rng(5);
  const Pose X = RandomPose(rng, 0.2);
  EXPECT_NEAR(PoseDistance(*object)(X, X * Pose(rng.Rotation())), 0, 1e-9);
}

std::vector<RawHypothesis> RandomVotes(int places, int count, Rng& rng) {
  std::vector<Pose> truth;
  for (int i = 0; i < places; ++i) truth.push_back(RandomPose(rng, 0.1));
  std::vector<RawHypothesis> raw;
  for (int i = 0; i < count; ++i) {
    RawHypothesis h;
    h.X_CO = Perturbed(truth[rng.Index(places)], rng.UnitVector(), rng.Uniform(0, 20),
                       0.004 * rng.UnitVector());
    if (rng.Uniform() < 0.3) h.X_CO = RandomPose(rng, 0.1);
    h.quick_score = static_cast<float>(rng.Index(50)) / 50;  // with ties
    raw.push_back(h);
  }
  return raw;
}

// The same rule, by comparing all pairs with PoseDistance itself.
std::vector<RawHypothesis> ClusterByAllPairs(std::vector<RawHypothesis> raw,
                                             const PoseDistance& distance, double radius,
                                             int max_kept) {
  std::stable_sort(raw.begin(), raw.end(),
                   [](const auto& a, const auto& b) { return a.quick_score > b.quick_score; });
  std::vector<RawHypothesis> kept;
  for (const RawHypothesis& h : raw) {
    const auto near = std::find_if(kept.begin(), kept.end(), [&](const RawHypothesis& k) {
      return distance(k.X_CO, h.X_CO) <= radius;
    });
    if (near != kept.end()) {
      near->votes += h.votes;
    } else if (static_cast<int>(kept.size()) < max_kept) {
      kept.push_back(h);
    }
  }
  return kept;
}

void ExpectSame(const std::vector<RawHypothesis>& a, const std::vector<RawHypothesis>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].X_CO.matrix(), b[i].X_CO.matrix()) << i;
    EXPECT_EQ(a[i].votes, b[i].votes) << i;
  }
}

TEST(ClusterVotes, EqualsAComparisonOfAllPairs) {
  const Pose half_turn = RotationAbout(Eigen::Vector3d::UnitZ(), std::numbers::pi);
  // The box is off its origin, so a symmetry moves the center of its bounding box.
  const TriangleMesh mesh = BoxMesh({0.06, 0.02, 0.02}, {0.01, 0.005, 0});
  for (const SymmetrySet& symmetries :
       {SymmetrySet{}, SymmetrySet{{half_turn}, {}}, SymmetrySet{{}, {ContinuousSymmetry{}}}}) {
    const auto object = ObjectOf(mesh, symmetries);
    const PoseDistance distance(*object);
    Rng rng(6);
    const std::vector<RawHypothesis> raw = RandomVotes(10, 600, rng);
    for (const int max_kept : {1000, 40}) {
      ExpectSame(ClusterVotes(raw, {distance}, 0.2, max_kept),
                 ClusterByAllPairs(raw, distance, 0.2, max_kept));
    }
  }
}

TEST(ClusterVotes, KeepsAllVotesAndRanksByScore) {
  const PoseDistance distance(*ObjectOf(BracketMesh()));
  Rng rng(7);
  const std::vector<RawHypothesis> raw = RandomVotes(5, 500, rng);
  const std::vector<RawHypothesis> kept = ClusterVotes(raw, {distance}, 0.15, 100000);
  const double votes = std::accumulate(kept.begin(), kept.end(), 0.0,
                                       [](double sum, const auto& h) { return sum + h.votes; });
  EXPECT_EQ(votes, 500);
  EXPECT_LT(kept.size(), 400u);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), [](const auto& a, const auto& b) {
    return a.quick_score > b.quick_score;
  }));
}

TEST(ClusterVotes, DifferentObjectsAreNotMerged) {
  const PoseDistance distance(*ObjectOf(BracketMesh()));
  std::vector<RawHypothesis> raw(2);
  raw[1].object = ObjectId{1};
  EXPECT_EQ(ClusterVotes(raw, {distance, distance}, 0.1, 10).size(), 2u);
  raw[1].object = ObjectId{0};
  EXPECT_EQ(ClusterVotes(raw, {distance, distance}, 0.1, 10).size(), 1u);
  EXPECT_TRUE(ClusterVotes({}, {}, 0.1, 10).empty());
}

}  // namespace
}  // namespace pickbed::tests
