#include "perception/voting/vote_density.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A box of 75 mm diameter. A shift moves each key point by its full length.
const Eigen::Vector3d kSize_m(0.06, 0.02, 0.04);

double DensityAt(const Pose& X_CO, const std::vector<PoseVote>& votes, int except_patch = -1,
                 const SymmetrySet& symmetries = {}) {
  const auto box = ObjectOf(BoxMesh(kSize_m, Eigen::Vector3d::Zero()), symmetries);
  const PoseEmbedding embedding(*box);
  VoteDensity::Scratch scratch;
  return VoteDensity(embedding, box->mass.com_O, box->diameter_m, 0.1, votes)
      .Around(X_CO, except_patch, scratch);
}

Pose Shifted(double diameters) { return Translation({diameters * kSize_m.norm(), 0, 0.5}); }

TEST(VoteDensity, FallsWithTheSquareOfTheDistance) {
  const std::vector<PoseVote> votes{{Shifted(0), 0}, {Shifted(0.05), 1}, {Shifted(0.11), 2}};
  EXPECT_NEAR(DensityAt(Shifted(0), votes), 1 + 0.75, 1e-3);
  EXPECT_NEAR(DensityAt(Shifted(0.05), votes), 0.75 + 1 + (1 - 0.36), 1e-3);
  EXPECT_EQ(DensityAt(Shifted(-3), votes), 0);
}

TEST(VoteDensity, VotesOfTheExceptedPatchDoNotCount) {
  const std::vector<PoseVote> votes{{Shifted(0), 4}, {Shifted(0), 4}, {Shifted(0), 5}};
  EXPECT_NEAR(DensityAt(Shifted(0), votes), 3, 1e-3);
  EXPECT_NEAR(DensityAt(Shifted(0), votes, 4), 1, 1e-3);
}

TEST(VoteDensity, SymmetricPosesCountAsEqual) {
  const Pose half_turn = Perturbed(Pose::Identity(), {0, 0, 1}, 180, {0, 0, 0});
  const std::vector<PoseVote> votes{{Shifted(0) * half_turn, 0}};
  EXPECT_EQ(DensityAt(Shifted(0), votes), 0);
  EXPECT_NEAR(DensityAt(Shifted(0), votes, -1, {{half_turn}, {}}), 1, 1e-3);
}

}  // namespace
}  // namespace pickbed::tests
