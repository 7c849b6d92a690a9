#include "grasp/plan/plan.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "grasp/candidates/antipodal.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/plan/clearance.h"
#include "scenes/base/error.h"
#include "tests/grasp/plan/plan_fixture.h"

namespace pickbed::tests {
namespace {

class Plan : public PlanFixture {};

// A pose that is not a target is still an obstacle.
TEST_F(Plan, OnlyTargetsAreGraspedAndOthersAreObstacles) {
  AddPose({0, 0, 0.025});
  AddPose({0.06, 0, 0.025});
  PlanOptions options;
  options.max_grasps = 1000;
  const PlanResult all = Run(options);
  const std::vector<int> targets{1};
  const PlanResult one =
      PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_, targets}, options);
  ASSERT_FALSE(one.grasps.empty());
  size_t for_one = 0;
  for (const Grasp& grasp : all.grasps) for_one += grasp.hypothesis == 1;
  EXPECT_LT(for_one, all.grasps.size());
  EXPECT_EQ(one.grasps.size(), for_one);
  for (const Grasp& grasp : one.grasps) EXPECT_EQ(grasp.hypothesis, 1);
}

// Two tools that differ in their candidates: the best grasps of both, and the sum of the causes.
TEST_F(Plan, BestGraspsOfAllToolsAreReported) {
  AddPose({0, 0, 0.025});
  ParallelJaw other = SmallJaw();
  other.name = "other jaw";
  std::vector<std::vector<GraspCandidate>> worse = candidates_;
  for (GraspCandidate& candidate : worse[0]) candidate.quality *= 0.999;
  PlanOptions options;
  options.max_grasps = 1000;
  const PlanInput first{bin_, poses_, candidates_, cloud_, objects_, gripper_};
  const PlanInput second{bin_, poses_, worse, cloud_, objects_, other};
  const PlanResult alone = PlanGrasps(first, options);
  const PlanResult both = PlanWithTools(std::vector<PlanInput>{second, first}, options);
  ASSERT_GT(both.grasps.size(), 1.9 * alone.grasps.size());
  EXPECT_EQ(both.grasps[0].tool, "test jaw") << "the first tool has no precedence";
  EXPECT_EQ(both.grasps[0].score, alone.grasps[0].score);
  EXPECT_TRUE(std::any_of(both.grasps.begin(), both.grasps.end(),
                          [](const Grasp& grasp) { return grasp.tool == "other jaw"; }));
  EXPECT_TRUE(std::is_sorted(both.grasps.begin(), both.grasps.end(),
                             [](const Grasp& a, const Grasp& b) { return a.score > b.score; }));
  EXPECT_EQ(Rejected(both) + static_cast<int>(both.grasps.size()),
            2 * static_cast<int>(candidates_[0].size()));
}

// A tool without a grasp is no reason to relax the constraints of the other.
TEST_F(Plan, ConstraintsAreRelaxedOnlyIfNoToolHasAGrasp) {
  AddPose({0, 0, 0.025});
  const std::vector<std::vector<GraspCandidate>> none(1);
  const PlanInput useless{bin_, poses_, none, cloud_, objects_, gripper_};
  const PlanInput useful{bin_, poses_, candidates_, cloud_, objects_, gripper_};
  const PlanResult both = PlanWithTools(std::vector<PlanInput>{useless, useful});
  EXPECT_FALSE(both.with_relaxed_constraints);
  EXPECT_FALSE(both.grasps.empty());
  EXPECT_TRUE(PlanGrasps(useless).with_relaxed_constraints);
}

// Equal tools have different random orders, else the first one would win each tie.
TEST_F(Plan, RandomOrderPrefersNoTool) {
  AddPose({0, 0, 0.025});
  ParallelJaw other = SmallJaw();
  other.name = "other jaw";
  const std::vector<PlanInput> inputs{{bin_, poses_, candidates_, cloud_, objects_, gripper_},
                                      {bin_, poses_, candidates_, cloud_, objects_, other}};
  int first = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const PlanOptions options{.ranking = "random", .seed = 1000 * seed};
    first += PlanWithTools(inputs, options).grasps.at(0).tool == gripper_.name;
  }
  EXPECT_NEAR(first, 20, 8) << "99 % of fair choices";
}

TEST_F(Plan, SingleBoxHasGraspsInOrderOfScore) {
  AddPose({0, 0, 0.025});
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

TEST_F(Plan, PosesAreReachableIfTheyHaveAGraspAsTheOnlyTarget) {
  AddPose({0, 0, 0.025});
  AddPose({0.5 * bin_.inner_size_m.x() - 0.025, 0.5 * bin_.inner_size_m.y() - 0.025, 0.025});
  AddPose({-0.1, 0, 0.025});
  AddPose({-0.1, 0, 0.075});  // on the third box, which has no free side at the top
  AddRing(0.05, 0.12);        // around the first box
  PlanOptions options;
  options.relaxed.enabled = false;
  int with_grasp = 0;
  for (int i = 0; i < static_cast<int>(poses_.size()); ++i) {
    const std::vector<int> targets{i};
    const PlanResult plan =
        PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_, targets}, options);
    with_grasp += !plan.grasps.empty();
  }
  EXPECT_GT(with_grasp, 0);
  EXPECT_LT(with_grasp, static_cast<int>(poses_.size()));
  const PlanInput input{bin_, poses_, candidates_, cloud_, objects_, gripper_};
  EXPECT_EQ(CountReachable({&input, 1}, 100, options), with_grasp);
  EXPECT_EQ(CountReachable({&input, 1}, 1, options), 1);
  const std::vector<int> third{2};
  const PlanInput one{bin_, poses_, candidates_, cloud_, objects_, gripper_, third};
  EXPECT_LE(CountReachable({&one, 1}, 100, options), 1) << "only targets count";
}

TEST_F(Plan, ReturnsAtMostMaxGrasps) {
  AddPose({0, 0, 0.025});
  EXPECT_EQ(Run().grasps.size(), 5u);
}

// Returned, rejected and untried candidates add up to all candidates of all poses.
TEST_F(Plan, EveryCandidateIsCounted) {
  AddPose({0, 0, 0.025});
  AddPose({0.07, 0.01, 0.025}, 0.9);
  AddRing(0.13, 0.04);
  const int all = 2 * static_cast<int>(candidates_[0].size());
  for (const int max_grasps : {1, 5, 100000}) {
    const PlanResult result = Run({.max_grasps = max_grasps});
    EXPECT_EQ(static_cast<int>(result.grasps.size()) + Rejected(result), all) << max_grasps;
    EXPECT_EQ(result.rejected.contains("not tried"), max_grasps < 100000);
  }
  const PlanResult random = Run({.max_grasps = 5, .ranking = "random"});
  EXPECT_EQ(static_cast<int>(random.grasps.size()) + Rejected(random), all);
}

TEST_F(Plan, FewGraspsAreTheFirstOfMany) {
  AddPose({0, 0, 0.025});
  AddPose({0.07, 0.01, 0.025}, 0.9);
  AddPose({-0.06, 0.05, 0.060}, 0.7);
  AddRing(0.13, 0.04);
  const auto few = Run().grasps, many = Run({.max_grasps = 100000}).grasps;
  ASSERT_EQ(few.size(), 5u);
  ASSERT_GT(many.size(), 50u);
  for (size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].X_WG.matrix(), many[i].X_WG.matrix());
    EXPECT_EQ(few[i].score, many[i].score);
  }
}

// Tips 14 mm past a contact 6 mm above the floor would be below the floor.
TEST_F(Plan, HandIsRetractedFromTheFloor) {
  AddPose({0, 0, 0.006});
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

// Pads of 20 mm centered on an object 9 mm from the wall would extend into the wall.
TEST_F(Plan, HandIsShiftedAwayFromAWall) {
  const double wall_m = 0.5 * bin_.inner_size_m.y();
  gripper_.hand.palm_size_m.y() = 0.02;
  GraspCandidate center;
  center.X_OG = FromAbove({0, 0, -0.010});
  center.width_m = 0.05;
  center.depth_m = 0.010;
  center.quality = 1;
  candidates_ = {{center}};
  AddPose({0, wall_m - 0.009, 0.025});
  const PlanResult result = Run();
  ASSERT_EQ(result.grasps.size(), 1u);
  const double edge_m = result.grasps[0].X_WG.translation().y() + 0.010;
  EXPECT_NEAR(edge_m, wall_m - PlanOptions{}.bin_clearance_m, 1e-5);
  poses_.clear();
  AddPose({0, wall_m - 0.004, 0.025});  // a shift of 8 mm is more than a quarter of the pads
  EXPECT_EQ(Run().rejected.at("bin wall"), 1);
}

TEST_F(Plan, PointsOfTheTargetAreNoObstacle) {
  AddPose({0, 0, 0.025});
  const size_t without = Run({.max_grasps = 1000}).grasps.size();
  Rng rng(1);
  for (const Vector3d& p : SampleSurface(objects_[0]->mesh_O, 5000, rng).points) {
    cloud_.push_back(poses_[0].X_WO * p);
  }
  EXPECT_EQ(Run({.max_grasps = 1000}).grasps.size(), without);
}

TEST_F(Plan, EnclosingPointsRejectAllGrasps) {
  AddPose({0, 0, 0.025});
  AddRing(0.045, 0.12);
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("fingers meet an instance"), 0);
}

TEST_F(Plan, NarrowWallsRejectAllGrasps) {
  AddPose({0, 0, 0.025});
  bin_.inner_size_m = {0.06, 0.06, 0.15};
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("bin wall"), 0);
}

TEST_F(Plan, PoseBelowTheFloorIsRejected) {
  AddPose({0, 0, -0.05});
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("bin floor"), 0);
}

TEST_F(Plan, SmallerStrokeRejectsByOpening) {
  AddPose({0, 0, 0.025});
  gripper_.hand.stroke_m = 0.05;
  const PlanResult result = Run();
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("opening"), 0);
}

TEST_F(Plan, PointsAboveTheTargetStopThePalm) {
  AddPose({0, 0, 0.025});
  for (double x = -0.01; x <= 0.01; x += 0.002) {
    for (double y = -0.01; y <= 0.01; y += 0.002) cloud_.emplace_back(x, y, 0.080);
  }
  EXPECT_GT(Run().rejected.at("palm meets an instance"), 0);
}

TEST_F(Plan, EstimatedNeighborIsAnObstacleWithoutPoints) {
  AddPose({0, 0, 0.025});
  const size_t single = Run({.max_grasps = 1000}).grasps.size();
  AddPose({0.053, 0, 0.025});
  int for_first = 0;
  for (const Grasp& grasp : Run({.max_grasps = 10000}).grasps) for_first += grasp.hypothesis == 0;
  EXPECT_LT(for_first, 0.8 * single);
  EXPECT_GT(for_first, 0);
}

TEST_F(Plan, NeighborOfLowConfidenceIsNoObstacle) {
  AddPose({0, 0, 0.025});
  const size_t single = Run({.max_grasps = 1000}).grasps.size();
  AddPose({0.053, 0, 0.025}, 0.05);
  size_t for_first = 0;
  for (const Grasp& grasp : Run({.max_grasps = 10000}).grasps) for_first += grasp.hypothesis == 0;
  EXPECT_EQ(for_first, single);
}

TEST_F(Plan, SecondPoseOfTheSameInstanceIsNoObstacle) {
  AddPose({0, 0, 0.025});
  AddPose({0.004, 0, 0.025});
  EXPECT_FALSE(Run().grasps.empty());
}

// Bars across each other have centers nearer than a quarter of their length, but they are two
// instances. Fingers that extend past the upper bar would hit the lower one.
TEST_F(Plan, FlatBarsAcrossEachOtherAreTwoInstances) {
  objects_[0] = BoxObject({0.10, 0.03, 0.016}, 0.2);
  GraspCandidate candidate;
  candidate.X_OG = FromAbove({0, 0, -0.006}, 0.5 * std::numbers::pi);
  candidate.width_m = 0.03;
  candidate.depth_m = 0.010;
  candidate.quality = 0.8;
  candidates_ = {{candidate}};
  AddPose({0, 0, 0.024});
  ASSERT_EQ(Run().grasps.size(), 1u);
  const std::vector<int> upper{0};
  const auto planned = [&] {
    PlanOptions options;
    options.relaxed.enabled = false;
    return PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_, upper}, options);
  };
  poses_.push_back({ObjectId{0},
                    Translation({0, 0, 0.008}) *
                        Pose(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ())),
                    1});
  EXPECT_TRUE(planned().grasps.empty());
  EXPECT_EQ(planned().rejected.at("fingers meet an instance"), 1);
  poses_[1].X_WO = poses_[0].X_WO * Translation({0.004, 0.002, 0.002});
  EXPECT_EQ(planned().grasps.size(), 1u) << "two estimated poses of the same instance";
}

// The same planner with another mechanism: the boxes of the cup are kept clear of wall and points.
class PlanCup : public Plan {
 protected:
  PlanCup() {
    selected_gripper_ = &cup_;
    GraspCandidate from_above;
    from_above.X_OG = FromAbove({0, 0, 0.025 - cup_.cup.press_m});
    from_above.quality = 1;
    candidates_ = {{from_above}};
    AddPose({0, 0, 0.025});
  }

  const SuctionCup cup_;
};

TEST_F(PlanCup, SingleBoxIsGraspedAtTheCandidate) {
  const PlanResult result = Run();
  ASSERT_EQ(result.grasps.size(), 1u);
  EXPECT_TRUE(result.grasps[0].X_WG.isApprox(poses_[0].X_WO * candidates_[0][0].X_OG));
}

TEST_F(PlanCup, PointsBesideTheStemRejectTheGrasp) {
  AddRing(cup_.cup.stem_radius_m + 0.002, 0.12);
  EXPECT_EQ(Run().rejected.at("fingers meet an instance"), 1);
}

TEST_F(PlanCup, PointsUnderThePalmRejectTheGrasp) {
  const double reach_m = 0.5 * cup_.cup.palm_size_m.x() - 0.002;
  ASSERT_GT(reach_m, cup_.cup.stem_radius_m + 0.006);
  AddRing(reach_m, 0.20);
  EXPECT_EQ(Run().rejected.at("palm meets an instance"), 1);
}

TEST_F(PlanCup, NarrowWallsRejectTheGrasp) {
  bin_.inner_size_m = {0.052, 0.052, 0.25};
  EXPECT_EQ(Run().rejected.at("bin wall"), 1);
}

TEST_F(Plan, NoPosesGiveNoGrasps) { EXPECT_TRUE(Run().grasps.empty()); }

TEST_F(Plan, PoseWithoutCandidatesIsALogicError) {
  poses_.push_back({ObjectId{1}, Pose::Identity(), 1});
  EXPECT_THROW(Run(), std::logic_error);
}

TEST_F(Plan, SameInputsGiveSameBytes) {
  AddPose({0, 0, 0.025});
  AddPose({0.1, 0.05, 0.025});
  AddRing(0.07, 0.04);
  const PlanResult a = Run(), b = Run();
  ASSERT_EQ(a.grasps.size(), b.grasps.size());
  for (size_t i = 0; i < a.grasps.size(); ++i) {
    EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
    EXPECT_EQ(a.grasps[i].score, b.grasps[i].score);
  }
}

}  // namespace
}  // namespace pickbed::tests
