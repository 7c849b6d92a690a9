#include "grasp/plan.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>
#include <stdexcept>

#include "grasp/antipodal.h"
#include "grasp/clearance.h"
#include "scenes/check.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

class Plan : public testing::Test {
 protected:
  Plan() : candidates_{BoxGrasps()} {}

  // Made once: they take longer than all the plans.
  static const std::vector<GraspCandidate>& BoxGrasps() {
    static const auto grasps = [] {
      Rng rng(1);
      return AntipodalGrasps(*BoxPart({0.05, 0.05, 0.05}, 0.2), SmallJaw(), rng,
                             {.candidates = 400, .max_pairs = 200});
    }();
    return grasps;
  }

  void Place(const Vector3d& p_W, double confidence = 1) {
    poses_.push_back({0, Translation(p_W), confidence});
  }

  PlanResult Run(const PlanOptions& options = {}) const {
    return PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_}, options);
  }

  int Rejected(const PlanResult& result) const {
    return std::accumulate(result.rejected.begin(), result.rejected.end(), 0,
                           [](int sum, const auto& entry) { return sum + entry.second; });
  }

  // Points of an upright wall around the origin.
  void AddRing(double radius_m, double height_m) {
    for (int turn = 0; turn < 180; ++turn) {
      const double angle = turn * std::numbers::pi / 90;
      for (double z = 0.01; z < height_m; z += 0.002) {
        cloud_.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), z);
      }
    }
  }

  Bin bin_;
  GripperSpec gripper_ = SmallJaw();
  ObjectSet objects_{BoxPart({0.05, 0.05, 0.05}, 0.2)};
  std::vector<std::vector<GraspCandidate>> candidates_;
  std::vector<BelievedPose> poses_;
  std::vector<Vector3d> cloud_;
};

// A pose that may not be grasped stands in the way all the same.
TEST_F(Plan, AimsAloneAreGraspedAndTheOthersStayObstacles) {
  Place({0, 0, 0.025});
  Place({0.06, 0, 0.025});
  PlanOptions options;
  options.max_grasps = 1000;
  const PlanResult all = Run(options);
  const std::vector<int> aims{1};
  const PlanResult one =
      PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_, aims}, options);
  ASSERT_FALSE(one.grasps.empty());
  size_t of_one = 0;
  for (const Grasp& grasp : all.grasps) of_one += grasp.hypothesis == 1;
  EXPECT_LT(of_one, all.grasps.size());
  EXPECT_EQ(one.grasps.size(), of_one);
  for (const Grasp& grasp : one.grasps) EXPECT_EQ(grasp.hypothesis, 1);
}

TEST_F(Plan, LoneBoxOnTheFloorHasGraspsBestFirst) {
  Place({0, 0, 0.025});
  PlanOptions options;
  options.max_grasps = 1000;
  const PlanResult result = Run(options);
  ASSERT_GT(result.grasps.size(), 20u);
  EXPECT_EQ(result.grasps.size() + Rejected(result), candidates_[0].size());
  const auto floor = BinBoxes(bin_);
  for (size_t i = 0; i < result.grasps.size(); ++i) {
    const Grasp& grasp = result.grasps[i];
    EXPECT_EQ(grasp.hypothesis, 0);
    if (i > 0) {
      EXPECT_LE(grasp.score, result.grasps[i - 1].score);
    }
    const auto sweep = HandSweep(gripper_, grasp.width_m + 0.006);
    EXPECT_FALSE(FindBinContact(sweep, grasp.X_WG, floor, options.bin_clearance_m));
    EXPECT_LE(std::acos(-grasp.X_WG.linear()(2, 2)), PlanOptions{}.max_tilt_rad);
  }
}

TEST_F(Plan, ReportsNoMoreThanAskedFor) {
  Place({0, 0, 0.025});
  EXPECT_EQ(Run().grasps.size(), 5u);
}

// What is reported, rejected and left untried are all the candidates of all poses.
TEST_F(Plan, EveryCandidateIsAccountedFor) {
  Place({0, 0, 0.025});
  Place({0.07, 0.01, 0.025}, 0.9);
  AddRing(0.13, 0.04);
  const int all = 2 * static_cast<int>(candidates_[0].size());
  for (const int most : {1, 5, 100000}) {
    const PlanResult result = Run({.max_grasps = most});
    EXPECT_EQ(static_cast<int>(result.grasps.size()) + Rejected(result), all) << most;
    EXPECT_EQ(result.rejected.contains("not tried"), most < 100000);
  }
  const PlanResult chance = Run({.max_grasps = 5, .ranking = "random"});
  EXPECT_EQ(static_cast<int>(chance.grasps.size()) + Rejected(chance), all);
}

TEST_F(Plan, FewAreTheFirstOfMany) {
  Place({0, 0, 0.025});
  Place({0.07, 0.01, 0.025}, 0.9);
  Place({-0.06, 0.05, 0.060}, 0.7);
  AddRing(0.13, 0.04);
  const auto few = Run().grasps, many = Run({.max_grasps = 100000}).grasps;
  ASSERT_EQ(few.size(), 5u);
  ASSERT_GT(many.size(), 50u);
  for (size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].X_WG.matrix(), many[i].X_WG.matrix());
    EXPECT_EQ(few[i].score, many[i].score);
  }
}

// Tips 14 mm past a contact that is 6 mm over the floor would stand below it.
TEST_F(Plan, HandDrawsBackFromTheFloor) {
  Place({0, 0, 0.006});
  GraspCandidate deep;
  deep.X_OG = FromAbove({0, 0, -0.014});
  deep.width_m = 0.05;
  deep.depth_m = 0.014;
  deep.quality = 1;
  candidates_ = {{deep}};
  const PlanResult result = Run();
  ASSERT_EQ(result.grasps.size(), 1u);
  const double tips = result.grasps[0].X_WG.translation().z();
  EXPECT_NEAR(tips, PlanOptions{}.bin_clearance_m, 1e-5);
  PlanOptions keep_depth;
  keep_depth.min_depth_m = 0.006;
  EXPECT_TRUE(Run(keep_depth).grasps.empty());
}

// Pads of 20 mm in the middle of a part that is 9 mm from the wall would reach into it.
TEST_F(Plan, HandStandsAsideForAWall) {
  const double wall_m = 0.5 * bin_.inner_size_m.y();
  gripper_.hand.palm_size_m.y() = 0.02;
  GraspCandidate middle;
  middle.X_OG = FromAbove({0, 0, -0.010});
  middle.width_m = 0.05;
  middle.depth_m = 0.010;
  middle.quality = 1;
  candidates_ = {{middle}};
  Place({0, wall_m - 0.009, 0.025});
  const PlanResult result = Run();
  ASSERT_EQ(result.grasps.size(), 1u);
  const double edge_m = result.grasps[0].X_WG.translation().y() + 0.010;
  EXPECT_NEAR(edge_m, wall_m - PlanOptions{}.bin_clearance_m, 1e-5);
  poses_.clear();
  Place({0, wall_m - 0.004, 0.025});  // 8 mm aside: more than a quarter of the pads
  EXPECT_EQ(Run().rejected.at("bin wall"), 1);
}

TEST_F(Plan, OwnPointsAreNoObstacle) {
  Place({0, 0, 0.025});
  const size_t without = Run({.max_grasps = 1000}).grasps.size();
  Rng rng(1);
  for (const Vector3d& p : SampleSurface(objects_[0]->mesh_O, 5000, rng).points) {
    cloud_.push_back(poses_[0].X_WO * p);
  }
  EXPECT_EQ(Run({.max_grasps = 1000}).grasps.size(), without);
}

TEST_F(Plan, EnclosingPointsRejectEverything) {
  Place({0, 0, 0.025});
  AddRing(0.045, 0.12);
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("fingers meet a part"), 0);
}

TEST_F(Plan, NarrowWallsRejectEverything) {
  Place({0, 0, 0.025});
  bin_.inner_size_m = {0.06, 0.06, 0.15};
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("bin wall"), 0);
}

TEST_F(Plan, SunkenPoseIsRejectedByTheFloor) {
  Place({0, 0, -0.05});
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("bin floor"), 0);
}

TEST_F(Plan, SmallerStrokeRejectsByOpening) {
  Place({0, 0, 0.025});
  gripper_.hand.stroke_m = 0.05;
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("opening"), 0);
}

TEST_F(Plan, PointsOverThePartStopThePalm) {
  Place({0, 0, 0.025});
  for (double x = -0.01; x <= 0.01; x += 0.002) {
    for (double y = -0.01; y <= 0.01; y += 0.002) cloud_.emplace_back(x, y, 0.080);
  }
  EXPECT_GT(Run().rejected.at("palm meets a part"), 0);
}

TEST_F(Plan, BelievedNeighbourIsAnObstacleWithoutBeingSeen) {
  Place({0, 0, 0.025});
  const size_t alone = Run({.max_grasps = 1000}).grasps.size();
  Place({0.053, 0, 0.025});
  int of_first = 0;
  for (const Grasp& grasp : Run({.max_grasps = 10000}).grasps) of_first += grasp.hypothesis == 0;
  EXPECT_LT(of_first, 0.8 * alone);
  EXPECT_GT(of_first, 0);
}

TEST_F(Plan, DoubtfulNeighbourIsNot) {
  Place({0, 0, 0.025});
  const size_t alone = Run({.max_grasps = 1000}).grasps.size();
  Place({0.053, 0, 0.025}, 0.1);
  size_t of_first = 0;
  for (const Grasp& grasp : Run({.max_grasps = 10000}).grasps) of_first += grasp.hypothesis == 0;
  EXPECT_EQ(of_first, alone);
}

TEST_F(Plan, RivalPoseForTheSamePartIsNot) {
  Place({0, 0, 0.025});
  Place({0.004, 0, 0.025});
  EXPECT_FALSE(Run().grasps.empty());
}

// Bars that lie across each other have their middles nearer than a quarter of their length: the
// lower one is a part all the same, and fingers that reach past the upper one would meet it.
TEST_F(Plan, FlatPartsAcrossEachOtherAreTwoParts) {
  objects_[0] = BoxPart({0.10, 0.03, 0.016}, 0.2);
  GraspCandidate candidate;
  candidate.X_OG = FromAbove({0, 0, -0.006}, 0.5 * std::numbers::pi);
  candidate.width_m = 0.03;
  candidate.depth_m = 0.010;
  candidate.quality = 0.8;
  candidates_ = {{candidate}};
  Place({0, 0, 0.024});
  ASSERT_EQ(Run().grasps.size(), 1u);
  const std::vector<int> upper{0};
  const auto planned = [&] {
    PlanOptions options;
    options.wide.look = false;
    return PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_, upper}, options);
  };
  poses_.push_back({0,
                    Translation({0, 0, 0.008}) *
                        Pose(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ())),
                    1});
  EXPECT_TRUE(planned().grasps.empty());
  EXPECT_EQ(planned().rejected.at("fingers meet a part"), 1);
  poses_[1].X_WO = poses_[0].X_WO * Translation({0.004, 0.002, 0.002});
  EXPECT_EQ(planned().grasps.size(), 1u) << "the same part, believed twice";
}

TEST_F(Plan, HigherAndSurerPartsComeFirst) {
  Place({-0.1, 0, 0.025});
  Place({0.1, 0, 0.075});
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 1);
  poses_[1].confidence = 0.2;
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 0);
}

TEST_F(Plan, CoveredPartComesLast) {
  Place({-0.1, 0, 0.025});
  Place({0.1, 0, 0.025});
  for (double x = 0.08; x <= 0.09; x += 0.002) {
    for (double y = -0.02; y <= 0.02; y += 0.002) cloud_.emplace_back(x, y, 0.06);
  }
  EXPECT_EQ(Run().grasps.at(0).hypothesis, 0);
}

// By the name of the ranking, the first grasp is the one that is best by it.
TEST_F(Plan, RankingChoosesWhichQualityCounts) {
  Place({0, 0, 0.025});
  GraspCandidate candidate = {};
  candidate.X_OG = FromAbove({0, 0, -0.010});
  candidate.width_m = 0.05;
  candidate.depth_m = 0.010;
  candidate.quality = 0.5;
  std::vector<GraspCandidate> candidates(3, candidate);
  const double places_m[] = {-0.006, 0, 0.006};
  for (int i = 0; i < 3; ++i) candidates[i].X_OG.translation().y() = places_m[i];
  candidates[0].quality = 0.6;
  candidates[1].epsilon = 0.8;
  candidates[2].robust = 0.9;
  candidates_ = {candidates};
  EXPECT_NEAR(Run({.ranking = "quality"}).grasps.at(0).X_WG.translation().y(), -0.006, 1e-12);
  EXPECT_NEAR(Run({.ranking = "epsilon"}).grasps.at(0).X_WG.translation().y(), 0, 1e-12);
  EXPECT_NEAR(Run({.ranking = "robust"}).grasps.at(0).X_WG.translation().y(), 0.006, 1e-12);
}

TEST_F(Plan, OfEqualGraspsTheOneThatCanSetThePartDownIsBetter) {
  Place({0, 0, 0.025});
  GraspCandidate candidate = {};
  candidate.X_OG = FromAbove({0, -0.006, -0.010});
  candidate.width_m = 0.05;
  candidate.depth_m = 0.010;
  candidate.quality = 0.5;
  std::vector<GraspCandidate> candidates(2, candidate);
  candidates[1].X_OG.translation().y() = 0.006;
  for (const int good : {0, 1}) {
    candidates[good].set_down = 1;
    candidates[1 - good].set_down = 0.1;
    candidates_ = {candidates};
    EXPECT_NEAR(Run().grasps.at(0).X_WG.translation().y(), good == 0 ? -0.006 : 0.006, 1e-12);
  }
}

TEST_F(Plan, UnknownRankingIsRefused) {
  Place({0, 0, 0.025});
  EXPECT_THROW(Run({.ranking = "randm"}), InputError);
}

// What is free is the same as with any ranking, but the best of it is not chosen more often than
// the rest; the seed alone says which.
TEST_F(Plan, RankingByChanceTakesAnyFreeGrasp) {
  Place({0, 0, 0.025});
  Place({0.1, 0, 0.025}, 0.1);
  const PlanResult all = Run({.max_grasps = 100000, .ranking = "random", .min_quality = 0});
  const PlanResult ranked = Run({.max_grasps = 100000, .min_quality = 0});
  EXPECT_EQ(all.grasps.size(), ranked.grasps.size());
  EXPECT_EQ(all.rejected, ranked.rejected);

  const int runs = 400;
  int of_doubtful = 0, free_of_doubtful = 0;
  for (const Grasp& grasp : all.grasps) free_of_doubtful += grasp.hypothesis;
  ASSERT_GT(free_of_doubtful, 20);
  for (int seed = 0; seed < runs; ++seed) {
    PlanOptions options;
    options.ranking = "random";
    options.seed = seed;
    options.max_grasps = 1;
    const PlanResult result = Run(options), again = Run(options);
    ASSERT_EQ(result.grasps.size(), 1u);
    EXPECT_EQ(result.grasps[0].X_WG.matrix(), again.grasps[0].X_WG.matrix());
    of_doubtful += result.grasps[0].hypothesis;
  }
  // As many as its share of what is free, to five standard deviations.
  EXPECT_NEAR(of_doubtful, runs * free_of_doubtful / static_cast<double>(all.grasps.size()), 50);
}

// The same plan for another mechanism: its own boxes are kept clear of wall and points.
class PlanCup : public Plan {
 protected:
  PlanCup() {
    gripper_ = GripperSpec{};
    gripper_.mechanism = "suction_cup";
    GraspCandidate from_above;
    from_above.X_OG = FromAbove({0, 0, 0.025 - gripper_.cup.press_m});
    from_above.quality = 1;
    candidates_ = {{from_above}};
    Place({0, 0, 0.025});
  }
};

TEST_F(PlanCup, LoneBoxIsTakenAsTheCandidateSays) {
  const PlanResult result = Run();
  ASSERT_EQ(result.grasps.size(), 1u);
  EXPECT_TRUE(result.grasps[0].X_WG.isApprox(poses_[0].X_WO * candidates_[0][0].X_OG));
}

TEST_F(PlanCup, PointsBesideTheStemRejectIt) {
  AddRing(gripper_.cup.stem_radius_m + 0.002, 0.12);
  EXPECT_EQ(Run().rejected.at("fingers meet a part"), 1);
}

TEST_F(PlanCup, PointsOutsideTheStemButUnderThePalmRejectIt) {
  const double reach_m = 0.5 * gripper_.cup.palm_size_m.x() - 0.002;
  ASSERT_GT(reach_m, gripper_.cup.stem_radius_m + 0.006);
  AddRing(reach_m, 0.20);
  EXPECT_EQ(Run().rejected.at("palm meets a part"), 1);
}

TEST_F(PlanCup, NarrowWallsRejectIt) {
  bin_.inner_size_m = {0.052, 0.052, 0.25};
  EXPECT_EQ(Run().rejected.at("bin wall"), 1);
}

TEST_F(Plan, NoPosesNoGrasps) { EXPECT_TRUE(Run().grasps.empty()); }

TEST_F(Plan, PoseOfAnObjectWithoutCandidatesIsACallersFault) {
  poses_.push_back({1, Pose::Identity(), 1});
  EXPECT_THROW(Run(), std::logic_error);
}

TEST_F(Plan, SameInputsSameBytes) {
  Place({0, 0, 0.025});
  Place({0.1, 0.05, 0.025});
  AddRing(0.07, 0.04);
  const PlanResult a = Run(), b = Run();
  ASSERT_EQ(a.grasps.size(), b.grasps.size());
  for (size_t i = 0; i < a.grasps.size(); ++i) {
    EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
    EXPECT_EQ(a.grasps[i].score, b.grasps[i].score);
  }
}

}  // namespace
}  // namespace pickbed
