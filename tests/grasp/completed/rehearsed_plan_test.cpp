#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "grasp/completed/completed_planner.h"
#include "grasp/grippers/suction_cup.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// Matter is possible beside the box, and the hand is allowed to enter it. So it hits the shape at
// the lower one of two levels.
class RehearsedBox : public ::testing::Test {
 protected:
  RehearsedBox() {
    scene_.AddBox(size_m_, pose_);
    options_.min_reported_score = 0;
    options_.grasps_observed = false;
    options_.smoothing = 0;
    options_.possible_level = options_.relaxed_level = 0.5;
  }
  PlanResult With(int rehearsals, std::shared_ptr<const Gripper> tool = nullptr,
                  int max_grasps = 1000, double min_score = 0) {
    if (tool == nullptr) tool = std::make_shared<ParallelJaw>(SmallJaw());
    const std::vector<std::shared_ptr<const Gripper>> tools{std::move(tool)};
    PlannerSpec spec;
    spec.rehearsals = rehearsals;
    spec.min_score = min_score;
    PlannerSetup setup{spec, tools, objects_, candidates_, {}, 2};
    setup.shapes = &shapes_;
    return CompletedPlanner(setup, options_).Plan(scene_.Input(max_grasps));
  }
  // Number of grasps whose score differs from the one without rehearsals.
  int Changed(const PlanResult& plain, const PlanResult& result) {
    int changed = 0;
    for (const Grasp& grasp : result.grasps) {
      const auto same = std::ranges::find_if(plain.grasps, [&](const Grasp& other) {
        return other.X_WG.matrix() == grasp.X_WG.matrix();
      });
      changed += same != plain.grasps.end() && same->score != grasp.score;
    }
    return changed;
  }

  const Vector3d size_m_{0.06, 0.045, 0.03};
  const Pose pose_ = OnFloor(0, 0, 0.03, 0);
  CloudScene scene_;
  GivenShapes shapes_{{ShapeOfBody(0.09, 48, pose_, [this](const Vector3d& p) {
    const double outside_m = (p.cwiseAbs() - 0.5 * size_m_).maxCoeff();
    return outside_m < 0 ? 1.0 : outside_m < 0.012 ? 0.4 : 0.0;
  })}};
  const ObjectSet objects_;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates_;
  CompletedPlannerOptions options_;
};

TEST_F(RehearsedBox, AHitLowersTheScore) {
  const PlanResult plain = With(0), result = With(3);
  ASSERT_GT(plain.grasps.size(), 3u);
  EXPECT_EQ(result.grasps.size(), plain.grasps.size());
  EXPECT_EQ(Changed(plain, result), 3);
  const double best = plain.grasps.front().score;
  EXPECT_NEAR(result.grasps.back().score, options_.chance.AfterRehearsal(best, 0.5, 0), 0.05);
  EXPECT_LT(result.grasps.back().score, plain.grasps.back().score);
  EXPECT_TRUE(std::ranges::is_sorted(result.grasps, std::greater(), &Grasp::score));
}

TEST_F(RehearsedBox, AHeldObjectKeepsTheScore) {
  options_.rehearsal.surface_levels = {0.45, 0.45};
  const PlanResult plain = With(0), result = With(3);
  ASSERT_FALSE(result.grasps.empty());
  EXPECT_EQ(result.grasps.front().X_WG.matrix(), plain.grasps.front().X_WG.matrix());
  EXPECT_EQ(Changed(plain, result), 0);
  // The same grasps hit the larger surface, so that they were rehearsed.
  options_.rehearsal.surface_levels = {0.3, 0.3};
  EXPECT_EQ(Changed(plain, With(3)), 3);
}

// Each grasp hits the box, so that the best one is rehearsed until all are worse than the best
// rehearsed one, or the number of rehearsals is used up.
TEST_F(RehearsedBox, TheFirstGraspIsRehearsed) {
  const PlanResult plain = With(0), all = With(100000), first = With(100000, nullptr, 1);
  ASSERT_FALSE(first.grasps.empty());
  EXPECT_EQ(Changed(plain, all), static_cast<int>(plain.grasps.size()));
  EXPECT_EQ(first.grasps.front().X_WG.matrix(), all.grasps.front().X_WG.matrix());
  EXPECT_EQ(first.grasps.front().score, all.grasps.front().score);
}

TEST_F(RehearsedBox, GraspsThatAreNotExecutedAreNotRehearsed) {
  const PlanResult plain = With(0);
  ASSERT_FALSE(plain.grasps.empty());
  const double above = plain.grasps.front().score + 0.001;
  EXPECT_EQ(Changed(plain, With(40, nullptr, 1000, above)), 0);
  EXPECT_GT(Changed(plain, With(40)), 0);
}

// Before rehearsals the grasps are good enough to be reported, and after them they are not.
TEST_F(RehearsedBox, ARehearsalLeavesNoGraspOut) {
  const PlanResult plain = With(0);
  options_.min_reported_score = plain.grasps.back().score;
  const PlanResult result = With(100000);
  EXPECT_EQ(result.grasps.size(), plain.grasps.size());
  EXPECT_LT(result.grasps.front().score, options_.min_reported_score);
}

TEST_F(RehearsedBox, CupsDoNotRehearse) {
  const auto cup = std::make_shared<SuctionCup>();
  const PlanResult plain = With(0, cup), result = With(3, cup);
  ASSERT_FALSE(plain.grasps.empty());
  ASSERT_EQ(result.grasps.size(), plain.grasps.size());
  EXPECT_EQ(Changed(plain, result), 0);
}

}  // namespace
}  // namespace pickbed::tests
