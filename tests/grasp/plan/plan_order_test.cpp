#include <stdexcept>

#include "scenes/base/error.h"
#include "tests/grasp/plan/plan_fixture.h"

namespace pickbed::tests {
namespace {

// Which of the free grasps comes first.
class PlanOrder : public PlanFixture {};

TEST_F(PlanOrder, HigherAndMoreConfidentPosesComeFirst) {
  AddPose({-0.1, 0, 0.025});
  AddPose({0.1, 0, 0.075});
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 1);
  poses_[1].confidence = 0.2;
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 0);
}

TEST_F(PlanOrder, CoveredInstanceComesLast) {
  AddPose({-0.1, 0, 0.025});
  AddPose({0.1, 0, 0.025});
  for (double x = 0.08; x <= 0.09; x += 0.002) {
    for (double y = -0.02; y <= 0.02; y += 0.002) cloud_.emplace_back(x, y, 0.06);
  }
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 0);
}

// Poses and candidates that cannot be among the best ones are not evaluated, which changes nothing.
TEST_F(PlanOrder, FewGraspsAreTheFirstOfMany) {
  Rng rng(3);
  for (int i = 0; i < 60; ++i) {
    AddPose({rng.Uniform(-0.15, 0.15), rng.Uniform(-0.1, 0.1), rng.Uniform(0.025, 0.12)},
            rng.Uniform());
    cloud_.push_back(poses_.back().X_WO * Eigen::Vector3d(0.02, 0, 0.025));
  }
  PlanOptions options;
  options.neighbor_confidence = PlanOptions::kNoNeighbors;
  options.max_grasps = 100000;
  const PlanResult all = Run(options);
  ASSERT_GT(all.grasps.size(), 20u);
  for (const int count : {1, 7, 20}) {
    options.max_grasps = count;
    const PlanResult few = Run(options);
    ASSERT_EQ(few.grasps.size(), static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) {
      EXPECT_EQ(few.grasps[i].hypothesis, all.grasps[i].hypothesis);
      EXPECT_EQ(few.grasps[i].score, all.grasps[i].score);
      EXPECT_EQ(few.grasps[i].X_WG.matrix(), all.grasps[i].X_WG.matrix());
    }
    EXPECT_GT(few.rejected.at("not tried"), 0);
  }
}

// The first grasp is the best according to the selected ranking.
TEST_F(PlanOrder, RankingSelectsTheQuality) {
  AddPose({0, 0, 0.025});
  GraspCandidate candidate = {};
  candidate.X_OG = FromAbove({0, 0, -0.010});
  candidate.width_m = 0.05;
  candidate.depth_m = 0.010;
  candidate.quality = 0.5;
  candidate.epsilon = 0.7;
  std::vector<GraspCandidate> candidates(3, candidate);
  const double positions_m[] = {-0.006, 0, 0.006};
  for (int i = 0; i < 3; ++i) candidates[i].X_OG.translation().y() = positions_m[i];
  candidates[0].quality = 0.6;
  candidates[1].epsilon = 0.8;
  candidates[2].robust = 0.9;
  candidates_ = {candidates};
  EXPECT_NEAR(Run({.ranking = "quality"}).grasps.at(0).X_WG.translation().y(), -0.006, 1e-12);
  EXPECT_NEAR(Run({.ranking = "epsilon"}).grasps.at(0).X_WG.translation().y(), 0, 1e-12);
  EXPECT_NEAR(Run({.ranking = "robust"}).grasps.at(0).X_WG.translation().y(), 0.006, 1e-12);
}

// A jaw that resists loads from all sides comes before a cup of somewhat better quality.
TEST_F(PlanOrder, QualityIsWeighedByTheLoadThatTheContactsResist) {
  AddPose({0, 0, 0.025});
  GraspCandidate candidate = {};
  candidate.X_OG = FromAbove({0, -0.006, -0.010});
  candidate.width_m = 0.05;
  candidate.depth_m = 0.010;
  candidate.quality = 0.5;
  candidate.epsilon = 5;
  std::vector<GraspCandidate> candidates(2, candidate);
  candidates[1].X_OG.translation().y() = 0.006;
  candidates[1].quality = 0.6;
  candidates[1].epsilon = 1;
  candidates_ = {candidates};
  EXPECT_NEAR(Run().grasps.at(0).X_WG.translation().y(), -0.006, 1e-12);
  EXPECT_NEAR(Run({.load_share = 0}).grasps.at(0).X_WG.translation().y(), 0.006, 1e-12);
}

TEST_F(PlanOrder, EqualGraspsAreRankedBySetDown) {
  AddPose({0, 0, 0.025});
  GraspCandidate candidate = {};
  candidate.X_OG = FromAbove({0, -0.006, -0.010});
  candidate.width_m = 0.05;
  candidate.depth_m = 0.010;
  candidate.quality = 0.5;
  std::vector<GraspCandidate> candidates(2, candidate);
  candidates[1].X_OG.translation().y() = 0.006;
  for (const int good : {0, 1}) {
    candidates[good].place_quality = 1;
    candidates[1 - good].place_quality = 0.1;
    candidates_ = {candidates};
    EXPECT_NEAR(Run().grasps.at(0).X_WG.translation().y(), good == 0 ? -0.006 : 0.006, 1e-12);
  }
}

TEST_F(PlanOrder, UnknownRankingIsRefused) {
  AddPose({0, 0, 0.025});
  EXPECT_THROW(Run({.ranking = "randm"}), InputError);
}

// Any ranking finds the same free grasps. With the random ranking, the seed selects among them with
// equal probability.
TEST_F(PlanOrder, RandomRankingSelectsAnyFreeGrasp) {
  AddPose({0, 0, 0.025});
  AddPose({0.1, 0, 0.025}, 0.1);
  const PlanResult all = Run({.max_grasps = 100000, .ranking = "random", .min_quality = 0});
  const PlanResult ranked = Run({.max_grasps = 100000, .min_quality = 0});
  EXPECT_EQ(all.grasps.size(), ranked.grasps.size());
  EXPECT_EQ(all.rejected, ranked.rejected);

  const int runs = 400;
  int uncertain = 0, free_uncertain = 0;
  for (const Grasp& grasp : all.grasps) free_uncertain += grasp.hypothesis;
  ASSERT_GT(free_uncertain, 20);
  for (int seed = 0; seed < runs; ++seed) {
    PlanOptions options;
    options.ranking = "random";
    options.seed = seed;
    options.max_grasps = 1;
    const PlanResult result = Run(options), again = Run(options);
    ASSERT_EQ(result.grasps.size(), 1u);
    EXPECT_EQ(result.grasps[0].X_WG.matrix(), again.grasps[0].X_WG.matrix());
    uncertain += result.grasps[0].hypothesis;
  }
  // The fraction among the free grasps, to five standard deviations.
  EXPECT_NEAR(uncertain, runs * free_uncertain / static_cast<double>(all.grasps.size()), 50);
}

}  // namespace
}  // namespace pickbed::tests
