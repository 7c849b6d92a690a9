#include "perception/voting/vote_modes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes/base/random.h"
#include "scenes/base/settings.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

Eigen::Quaterniond Rotation(const Eigen::Vector3d& axis, double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis.normalized()));
}

SymmetrySet HalfTurn() {
  SymmetrySet symmetries;
  symmetries.discrete_O = {
      MakePose(Rotation({0, 0, 1}, std::numbers::pi).toRotationMatrix(), Eigen::Vector3d::Zero())};
  return symmetries;
}

SymmetrySet AnyRotation() {
  SymmetrySet symmetries;
  symmetries.continuous_O = {ContinuousSymmetry{}};
  return symmetries;
}

// Votes around a pose: rotated by up to `max_rotation_rad` about any axis and moved by `shift_m`.
std::vector<CastVote> VotesAbout(const Pose& X_CO, int count, double max_rotation_rad,
                                 double shift_m, Rng& rng) {
  std::vector<CastVote> votes;
  for (int i = 0; i < count; ++i) {
    const Pose off =
        MakePose(Rotation(rng.UnitVector(), rng.Uniform(-max_rotation_rad, max_rotation_rad))
                     .toRotationMatrix(),
                 shift_m * rng.UnitVector());
    votes.push_back({X_CO * off, 0.2f});
  }
  return votes;
}

TEST(MeanRotation, MeanOfRotationsAboutOneAxisIsCentral) {
  const Eigen::Vector3d axis(1, 2, -1);
  const Eigen::Quaterniond base = Rotation({0, 1, 1}, 2.1);
  std::vector<Eigen::Quaterniond> rotations;
  for (const double angle : {-0.3, -0.1, 0.1, 0.3})
    rotations.push_back(base * Rotation(axis, angle));
  rotations[1].coeffs() *= -1;  // the same rotation
  const std::vector<double> weights(4, 1.0);
  EXPECT_LT(MeanRotation(rotations, weights).angularDistance(base), 1e-7);
  // A doubled weight is equivalent to a repeated rotation.
  std::vector<Eigen::Quaterniond> twice = rotations;
  twice.push_back(rotations[3]);
  const Eigen::Quaterniond mean = MeanRotation(rotations, std::vector<double>{1, 1, 1, 2});
  EXPECT_LT(mean.angularDistance(MeanRotation(twice, std::vector<double>(5, 1.0))), 1e-7);
  EXPECT_GT(mean.angularDistance(base), 0.03);
}

TEST(ObjectRotations, SymmetricRotationsHaveZeroAngle) {
  const Eigen::Quaterniond q = Rotation({1, -2, 0.5}, 1.3);
  const Eigen::Quaterniond turned = q * Rotation({0, 0, 1}, std::numbers::pi);
  EXPECT_NEAR(ObjectRotations({}).Angle(q, turned), std::numbers::pi, 1e-7);
  EXPECT_NEAR(ObjectRotations(HalfTurn()).Angle(q, turned), 0, 1e-7);
  // About a continuous symmetry axis, the nearest of 24 steps leaves a remainder.
  EXPECT_LT(ObjectRotations(AnyRotation()).Angle(q, q * Rotation({0, 0, 1}, 1.7)),
            std::numbers::pi / 24);
  EXPECT_NEAR(ObjectRotations(AnyRotation()).Angle(q, q * Rotation({1, 0, 0}, 0.4)), 0.4, 1e-6);
}

class VoteModes : public testing::Test {
 protected:
  std::vector<VoteMode> Find(const std::vector<CastVote>& votes, const SymmetrySet& symmetries) {
    const auto model = ObjectOf(BracketMesh(), symmetries);
    return FindVoteModes(*model, ObjectRotations(symmetries), votes, options_);
  }
  // Returns whether one of the first `count` modes is near the pose.
  static bool Holds(const std::vector<VoteMode>& modes, size_t count, const Pose& X_CO,
                    const ObjectRotations& rotations) {
    for (size_t i = 0; i < std::min(count, modes.size()); ++i) {
      const double angle = rotations.Angle(Eigen::Quaterniond(modes[i].X_CO.linear()),
                                           Eigen::Quaterniond(X_CO.linear()));
      if (angle < 0.05 && (modes[i].X_CO.translation() - X_CO.translation()).norm() < 0.002) {
        return true;
      }
    }
    return false;
  }
  ModeOptions options_;
  Rng rng_{3};
  const Pose first_ = MakePose(Rotation({1, 1, 0}, 0.7).toRotationMatrix(), {0.02, 0.01, 0.6});
  const Pose second_ = MakePose(Rotation({0, 1, 2}, -1.9).toRotationMatrix(), {-0.06, 0.03, 0.62});
};

TEST_F(VoteModes, PlantedModesAreFoundAmongOutliers) {
  std::vector<CastVote> votes = VotesAbout(first_, 30, 0.15, 0.002, rng_);
  // `flipped` is at the same place with another rotation and gets no votes; `second_` is elsewhere.
  const Pose flipped = first_ * MakePose(Rotation({0, 1, 0}, 2.5).toRotationMatrix(), {0, 0, 0});
  for (const CastVote& vote : VotesAbout(second_, 20, 0.15, 0.002, rng_)) votes.push_back(vote);
  for (int i = 0; i < 200; ++i) {
    const Pose stray = MakePose(Rotation(rng_.UnitVector(), rng_.Uniform(0, 3)).toRotationMatrix(),
                                {rng_.Uniform(-0.2, 0.2), rng_.Uniform(-0.2, 0.2), 0.6});
    votes.push_back({stray, 0.2f});
  }
  const std::vector<VoteMode> modes = Find(votes, {});
  const ObjectRotations rotations({});
  EXPECT_TRUE(Holds(modes, 2, first_, rotations));
  EXPECT_TRUE(Holds(modes, 2, second_, rotations));
  EXPECT_FALSE(Holds(modes, modes.size(), flipped, rotations));
  for (size_t i = 1; i < modes.size(); ++i) EXPECT_LE(modes[i].weight, modes[i - 1].weight);
  EXPECT_GE(modes[0].votes, 25);
}

TEST_F(VoteModes, TwoRotationsAtOnePlaceAreTwoModes) {
  std::vector<CastVote> votes = VotesAbout(first_, 30, 0.1, 0.001, rng_);
  // Rotated about the center of mass, which stays where it is.
  const auto model = ObjectOf(BracketMesh());
  const Eigen::Matrix3d R = Rotation({0, 1, 0}, 2.5).toRotationMatrix();
  const Eigen::Vector3d com_O = model->mass.com_O;
  const Pose flipped = first_ * MakePose(R, com_O - R * com_O);
  for (const CastVote& vote : VotesAbout(flipped, 20, 0.1, 0.001, rng_)) votes.push_back(vote);
  const std::vector<VoteMode> modes = Find(votes, {});
  ASSERT_GE(modes.size(), 2u);
  const ObjectRotations rotations({});
  EXPECT_TRUE(Holds(modes, 1, first_, rotations));
  EXPECT_TRUE(Holds(modes, 2, flipped, rotations));
}

TEST_F(VoteModes, SymmetricVotesAreOneMode) {
  std::vector<CastVote> votes = VotesAbout(first_, 30, 0.1, 0.001, rng_);
  const auto model = ObjectOf(BracketMesh(), HalfTurn());
  const Eigen::Vector3d com_O = model->mass.com_O;
  const Eigen::Matrix3d R = Rotation({0, 0, 1}, std::numbers::pi).toRotationMatrix();
  for (size_t i = 0; i < votes.size(); i += 2) {
    votes[i].X_CO = votes[i].X_CO * MakePose(R, com_O - R * com_O);
  }
  EXPECT_EQ(Find(votes, HalfTurn()).size(), 1u);
  EXPECT_EQ(Find(votes, HalfTurn())[0].votes, 30);
  EXPECT_EQ(Find(votes, {}).size(), 2u);
}

TEST_F(VoteModes, VotesOfDistantNeighborsAreIgnored) {
  std::vector<CastVote> votes = VotesAbout(first_, 30, 0.1, 0.001, rng_);
  for (CastVote& vote : votes) vote.distance = static_cast<float>(options_.max_distance + 0.01);
  EXPECT_TRUE(Find(votes, {}).empty());
  EXPECT_TRUE(Find({}, {}).empty());
}

TEST_F(VoteModes, NearerNeighborsHaveMoreWeight) {
  std::vector<CastVote> votes = VotesAbout(first_, 20, 0.1, 0.001, rng_);
  std::vector<CastVote> nearer = VotesAbout(second_, 20, 0.1, 0.001, rng_);
  for (CastVote& vote : nearer) vote.distance = 0.1f;
  votes.insert(votes.end(), nearer.begin(), nearer.end());
  const std::vector<VoteMode> modes = Find(votes, {});
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_TRUE(Holds(modes, 1, second_, ObjectRotations({})));
  EXPECT_NEAR(modes[0].weight, 20 * std::exp(-0.1), 1e-5);
  EXPECT_NEAR(modes[1].weight, 20 * std::exp(-0.2), 1e-5);
}

TEST(ModeOptions, OutOfRangeSettingsReportTheRange) {
  ModeOptions options;
  const std::string error = ErrorOf(
      [&] { ApplySetting("center_diameters=0", [&](SettingsVisitor& v) { options.Visit(v); }); });
  EXPECT_THAT(error, testing::HasSubstr("center_diameters"));
  EXPECT_THAT(error, testing::HasSubstr("0.001"));
}

}  // namespace
}  // namespace pickbed::tests
