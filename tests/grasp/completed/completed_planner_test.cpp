#include "grasp/completed/completed_planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/completed/success_network.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/planners/table.h"
#include "scenes/base/math.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kRadius_m = 0.02;
const Pose kSpherePose = OnFloor(0.03, -0.02, 2 * kRadius_m, 0);

class CompletedPlan {
 public:
  explicit CompletedPlan(std::vector<OccupancyShape> shapes,
                         std::shared_ptr<const Gripper> tool = nullptr,
                         double min_reported_score = 0, ImageSegments segments = {})
      : shapes_(std::move(shapes), std::move(segments)),
        tools_{tool != nullptr ? tool : std::make_shared<ParallelJaw>(SmallJaw())},
        planner_(Setup(), Options(min_reported_score)) {}

  PlanResult Of(const PlannerInput& input) { return planner_.Plan(input); }
  const Gripper& tool() const { return *tools_.front(); }

 private:
  // Grasps of the observed surface would hide what the shapes give.
  static CompletedPlannerOptions Options(double min_reported_score) {
    CompletedPlannerOptions options;
    options.min_reported_score = min_reported_score;
    options.grasps_observed = false;
    return options;
  }
  PlannerSetup Setup() {
    PlannerSetup setup{PlannerSpec(), tools_, objects_, candidates_, {}, 2};
    setup.shapes = &shapes_;
    return setup;
  }

  GivenShapes shapes_;
  std::vector<std::shared_ptr<const Gripper>> tools_;
  ObjectSet objects_;
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates_;
  CompletedPlanner planner_;
};

TriangleMesh SphereMesh(double radius_m) {
  const OccupancyShape shape = SphereShape(radius_m, Pose::Identity());
  return Transformed(SurfaceOf(Smoothed(shape), 0.5), shape.X_WV);
}

CloudScene SphereScene() {
  CloudScene scene;
  scene.AddMesh(SphereMesh(kRadius_m), kSpherePose);
  return scene;
}

// Whether a point is in one of the boxes of the hand on its approach.
bool IsInHand(const Gripper& tool, const Grasp& grasp, const Vector3d& p_W, double margin_m) {
  const Vector3d p_G = grasp.X_WG.inverse() * p_W;
  for (const AxisAlignedBox& box : HandSweep(tool, *tool.ApproachOpening_m(grasp.width_m))) {
    if (((p_G - box.center).cwiseAbs() - box.half_size).maxCoeff() < -margin_m) return true;
  }
  return false;
}

TEST(CompletedPlanner, ClosesOnASphereThroughItsCenter) {
  const CloudScene scene = SphereScene();
  CompletedPlan plan({SphereShape(kRadius_m, kSpherePose)});
  const PlanResult result = plan.Of(scene.Input());
  ASSERT_FALSE(result.grasps.empty());
  for (const Grasp& grasp : result.grasps) {
    EXPECT_EQ(grasp.hypothesis, kNoHypothesis);
    EXPECT_EQ(grasp.tool, plan.tool().name);
    const Vector3d center_G = grasp.X_WG.inverse() * kSpherePose.translation();
    EXPECT_LT(std::abs(center_G.y()), 0.006) << "the closing line passes the solid";
    EXPECT_GT(grasp.width_m, 1.5 * kRadius_m);
    EXPECT_LT(grasp.X_WG.linear()(2, 2), 0) << "from above";
  }
}

// Two equal spheres, of which others cover one.
TEST(CompletedPlanner, AFreeObjectComesBeforeACoveredOne) {
  const Pose left = OnFloor(-0.06, 0, 2 * kRadius_m, 0), right = OnFloor(0.06, 0, 2 * kRadius_m, 0);
  CloudScene scene;
  scene.AddMesh(SphereMesh(kRadius_m), left);
  scene.AddMesh(SphereMesh(kRadius_m), right);
  ImageSegments segments = LeftAndRight(scene);
  for (const int covered : {0, 1}) {
    for (int i = 0; i < 2; ++i) {
      const Pose& pose = i == 0 ? left : right;
      segments.segments[i].center_C = scene.camera().X_CW() * pose.translation();
      segments.segments[i].covered = i == covered ? 0.4 : 0;
    }
    CompletedPlan plan({SphereShape(kRadius_m, left), SphereShape(kRadius_m, right)}, nullptr, 0,
                       segments);
    const PlanResult result = plan.Of(scene.Input(1000));
    ASSERT_FALSE(result.grasps.empty());
    const double first_x = result.grasps.front().X_WG.translation().x();
    EXPECT_EQ(first_x < 0, covered == 1);
    const SuccessChance chance;
    double covered_chance = 0, free_chance = 0;
    for (const Grasp& grasp : result.grasps) {
      const bool is_covered = (grasp.X_WG.translation().x() < 0) == (covered == 0);
      double& best = is_covered ? covered_chance : free_chance;
      best = std::max(best, grasp.score);
    }
    ASSERT_GT(covered_chance, 0);
    EXPECT_NEAR(
        std::log(free_chance / (1 - free_chance)) - std::log(covered_chance / (1 - covered_chance)),
        0.4 * chance.covered, 0.5);
  }
}

TEST(CompletedPlanner, NoHandEntersOccupiedCells) {
  CloudScene scene = SphereScene();
  const Pose box_pose = OnFloor(-0.03, 0.02, 0.03, 0.4);
  const OccupancyShape sphere = SphereShape(kRadius_m, kSpherePose);
  const OccupancyShape box = BoxShape({0.05, 0.03, 0.03}, box_pose);
  scene.AddBox({0.05, 0.03, 0.03}, box_pose);
  CompletedPlan plan({sphere, box});
  const PlanResult result = plan.Of(scene.Input(20));
  ASSERT_FALSE(result.grasps.empty());
  for (const Grasp& grasp : result.grasps) {
    for (const OccupancyShape* shape : {&sphere, &box}) {
      for (const Vector3d& p_W : ShellOf(*shape, 0.5)) {
        EXPECT_FALSE(IsInHand(plan.tool(), grasp, p_W, 0.5 * shape->cell_m));
      }
    }
  }
}

// An object whose side may go further than its probable surface.
TEST(CompletedPlanner, TheHandKeepsOutOfPossibleMatter) {
  CloudScene scene;
  const Vector3d size(0.06, 0.025, 0.03);
  const Pose pose = OnFloor(0, 0, size.z(), 0);
  scene.AddBox(size, pose);
  const auto with_margin = [&](double margin_m) {
    return ShapeOfBody(0.09, 48, pose, [&](const Vector3d& p) {
      const double outside = (p.cwiseAbs() - 0.5 * size).maxCoeff();
      return outside < 0 ? 1.0 : outside < margin_m ? 0.4 : 0.0;
    });
  };
  const PlanResult sure = CompletedPlan({with_margin(0)}).Of(scene.Input());
  const OccupancyShape unsure_shape = with_margin(0.012);
  CompletedPlan unsure_plan({unsure_shape});
  const PlanResult unsure = unsure_plan.Of(scene.Input());
  ASSERT_FALSE(sure.grasps.empty());
  ASSERT_FALSE(unsure.grasps.empty());
  EXPECT_GT(unsure.grasps.front().width_m, sure.grasps.front().width_m + 0.005);
  for (const Grasp& grasp : unsure.grasps) {
    for (const Vector3d& p_W : ShellOf(unsure_shape, 0.3)) {
      EXPECT_FALSE(IsInHand(unsure_plan.tool(), grasp, p_W, 1.5 * unsure_shape.cell_m));
    }
  }
}

// No cell of the shape reaches the grasped level, so that all grasps are of the observed surface.
TEST(CompletedPlanner, TheHandKeepsOutOfPossibleMatterAtTheObservedSurface) {
  CloudScene scene;
  const Vector3d size(0.06, 0.025, 0.03);
  const Pose pose = OnFloor(0, 0, size.z(), 0);
  scene.AddBox(size, pose);
  const OccupancyShape beside = ShapeOfBody(0.12, 48, pose, [&](const Vector3d& p) {
    return p.x() > 0 && p.x() < 0.03 && p.y() > 0.0125 && p.y() < 0.05 && p.z() < 0.015 ? 0.4 : 0.0;
  });
  const std::vector<std::shared_ptr<const Gripper>> tools{
      std::make_shared<ParallelJaw>(SmallJaw())};
  const ObjectSet objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  GivenShapes shapes({beside});
  PlannerSetup setup{PlannerSpec(), tools, objects, candidates, {}, 2};
  setup.shapes = &shapes;
  CompletedPlannerOptions options;
  options.min_reported_score = 0;
  options.smoothing = 0;
  const auto touching = [&](const CompletedPlannerOptions& set) {
    const PlanResult result = CompletedPlanner(setup, set).Plan(scene.Input(1000));
    EXPECT_FALSE(result.grasps.empty());
    return std::ranges::count_if(result.grasps, [&](const Grasp& grasp) {
      return std::ranges::any_of(ShellOf(beside, 0.3), [&](const Vector3d& p_W) {
        return IsInHand(*tools.front(), grasp, p_W, 1.5 * beside.cell_m);
      });
    });
  };
  EXPECT_EQ(touching(options), 0);
  // Matter all around leaves no grasp, also if both levels are equal.
  const OccupancyShape around = ShapeOfBody(0.2, 48, pose, [](const Vector3d&) { return 0.4; });
  GivenShapes everywhere({around});
  PlannerSetup blocked = setup;
  blocked.shapes = &everywhere;
  options.relaxed_level = options.possible_level;
  EXPECT_TRUE(CompletedPlanner(blocked, options).Plan(scene.Input(1000)).grasps.empty());
  options.relaxed_level = 0.2;
  EXPECT_THAT(ErrorOf([&] { CompletedPlanner(setup, options); }), HasSubstr("relaxed_level"));
  options.possible_level = options.relaxed_level = 0.6;
  EXPECT_GT(touching(options), 0) << "to show that grasps without the test enter the cells";
}

// A tall box hides the space behind it. A hand that reaches into it is ranked last or not at all.
TEST(CompletedPlanner, AvoidsTheShadowOfAnotherPart) {
  CloudScene scene({0, -0.35, 0.45});
  const Vector3d size(0.03, 0.03, 0.03);
  const Pose pose = OnFloor(0, 0.03, size.z(), 0);
  scene.AddBox(size, pose);
  scene.AddBox({0.20, 0.02, 0.08}, OnFloor(0, -0.04, 0.08, 0));
  CompletedPlan plan({BoxShape(size, pose)});
  const PlanResult result = plan.Of(scene.Input());
  ASSERT_FALSE(result.grasps.empty());
  const HiddenSpace hidden(scene.frame().depth_m, scene.frame().intrinsics, scene.camera().X_CW(),
                           0.005);
  const Grasp& best = result.grasps.front();
  const auto sweep = HandSweep(plan.tool(), *plan.tool().ApproachOpening_m(best.width_m));
  EXPECT_LT(hidden.MeanDepth_m(sweep, best.X_WG, 0.004), 0.01);
}

TEST(CompletedPlanner, SuctionSealsOnTheTopOfABox) {
  CloudScene scene;
  const Vector3d size(0.06, 0.05, 0.03);
  const Pose pose = OnFloor(0.01, 0.02, size.z(), 0.3);
  scene.AddBox(size, pose);
  CompletedPlan plan({BoxShape(size, pose)}, std::make_shared<SuctionCup>());
  const PlanResult result = plan.Of(scene.Input());
  ASSERT_FALSE(result.grasps.empty());
  const Grasp& best = result.grasps.front();
  EXPECT_NEAR(best.X_WG.translation().z(), size.z(), 0.004);
  EXPECT_LT((best.X_WG.translation() - pose.translation()).head<2>().norm(), 0.015);
}

// The slab is too wide for the jaw, and the bar too narrow for the cup.
TEST(CompletedPlanner, GivesEachObjectTheToolThatHoldsIt) {
  CloudScene scene;
  const Vector3d slab(0.1, 0.1, 0.03), bar(0.012, 0.06, 0.04);
  const Pose slab_pose = OnFloor(-0.07, 0, slab.z(), 0), bar_pose = OnFloor(0.07, 0, bar.z(), 0);
  scene.AddBox(slab, slab_pose);
  scene.AddBox(bar, bar_pose);
  const auto cup = std::make_shared<SuctionCup>();
  cup->name = "test cup";
  const std::vector<std::shared_ptr<const Gripper>> tools{std::make_shared<ParallelJaw>(SmallJaw()),
                                                          cup};
  ASSERT_LT(tools[0]->MaxOpening_m(), slab.x());
  const ObjectSet objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  GivenShapes shapes({BoxShape(slab, slab_pose), BoxShape(bar, bar_pose)});
  PlannerSetup setup{PlannerSpec(), tools, objects, candidates, {}, 2};
  setup.shapes = &shapes;
  CompletedPlannerOptions options;
  options.min_reported_score = 0;
  const PlanResult result = CompletedPlanner(setup, options).Plan(scene.Input(1000));
  int of_slab = 0, of_bar = 0;
  for (const Grasp& grasp : result.grasps) {
    const bool on_slab = grasp.X_WG.translation().x() < 0;
    EXPECT_EQ(grasp.tool, on_slab ? cup->name : tools[0]->name);
    ++(on_slab ? of_slab : of_bar);
  }
  EXPECT_GT(of_slab, 0);
  EXPECT_GT(of_bar, 0);
}

TEST(CompletedPlanner, WorksWithoutAKnownBin) {
  const CloudScene scene = SphereScene();
  PlannerInput input = scene.Input();
  input.bin.reset();
  EXPECT_FALSE(CompletedPlan({SphereShape(kRadius_m, kSpherePose)}).Of(input).grasps.empty());
}

TEST(CompletedPlanner, WithoutPartsThereIsNoGrasp) {
  const CloudScene scene;
  EXPECT_TRUE(CompletedPlan({}).Of(scene.Input()).grasps.empty());
  OccupancyShape empty = SphereShape(kRadius_m, kSpherePose);
  std::fill(empty.occupancy.begin(), empty.occupancy.end(), 0.0f);
  EXPECT_TRUE(CompletedPlan({empty}).Of(scene.Input()).grasps.empty());
}

TEST(CompletedPlanner, NamesSegmentsWithoutAShapeAmongTheRejections) {
  const CloudScene scene;
  ImageSegments segments;
  segments.without_shape = 3;
  const PlanResult result = CompletedPlan({}, nullptr, 0, segments).Of(scene.Input());
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_EQ(result.rejected, (std::map<std::string, int>{{"segment without shape", 3}}));
}

TEST(CompletedPlanner, EqualImagesGiveEqualGrasps) {
  const CloudScene scene = SphereScene();
  CompletedPlan plan({SphereShape(kRadius_m, kSpherePose)});
  const PlanResult a = plan.Of(scene.Input()), b = plan.Of(scene.Input());
  ASSERT_EQ(a.grasps.size(), b.grasps.size());
  for (size_t i = 0; i < a.grasps.size(); ++i) {
    EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
    EXPECT_EQ(a.grasps[i].score, b.grasps[i].score);
  }
}

TEST(CompletedPlanner, GraspsTheObservedSurfaceIfShapesGiveNoGrasp) {
  const CloudScene scene = SphereScene();
  const std::vector<std::shared_ptr<const Gripper>> tools{
      std::make_shared<ParallelJaw>(SmallJaw())};
  const ObjectSet objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  GivenShapes none({});
  PlannerSetup setup{PlannerSpec(), tools, objects, candidates, {}, 2};
  setup.shapes = &none;
  const PlanResult on_surface = CloudAntipodal(setup).Plan(scene.Input());
  const PlanResult result = CompletedPlanner(setup).Plan(scene.Input());
  ASSERT_FALSE(on_surface.grasps.empty());
  ASSERT_EQ(result.grasps.size(), on_surface.grasps.size());
  EXPECT_EQ(result.grasps.front().X_WG.matrix(), on_surface.grasps.front().X_WG.matrix());
}

// The shape of an object at a wall may reach through the wall.
TEST(CompletedPlanner, DoesNotCloseAcrossAWall) {
  CloudScene scene;
  const Vector3d size(0.04, 0.05, 0.045);
  const Pose pose = OnFloor(0.148, 0, size.z(), 0);
  scene.AddBox({0.02, 0.05, 0.045}, OnFloor(0.139, 0, 0.045, 0));
  const auto across = [&](const PlanResult& result, const CompletedPlan& plan) {
    return std::ranges::count_if(result.grasps, [&](const Grasp& grasp) {
      const double opening_m = *plan.tool().ApproachOpening_m(grasp.width_m);
      return HandMeetsBin(plan.tool(), opening_m, grasp.X_WG, BinBoxes(scene.bin()), 0);
    });
  };
  CompletedPlan plan({BoxShape(size, pose)});
  PlannerInput input = scene.Input(1000);
  EXPECT_EQ(across(plan.Of(input), plan), 0);
  input.bin.reset();
  EXPECT_GT(across(plan.Of(input), plan), 0) << "an unknown bin, to show that the shape has them";
}

// The sphere has both kinds of grasps. Their order follows from their chances.
TEST(CompletedPlanner, RanksBothKindsOfGraspsByTheirChance) {
  const CloudScene scene = SphereScene();
  const std::vector<std::shared_ptr<const Gripper>> tools{
      std::make_shared<ParallelJaw>(SmallJaw())};
  const ObjectSet objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  GivenShapes shapes({SphereShape(kRadius_m, kSpherePose)});
  PlannerSetup setup{PlannerSpec(), tools, objects, candidates, {}, 2};
  setup.shapes = &shapes;
  const PlanResult observed = CloudAntipodal(setup).Plan(scene.Input(20));
  ASSERT_FALSE(observed.grasps.empty());
  const auto is_observed = [&](const Grasp& grasp) {
    return std::ranges::any_of(observed.grasps, [&](const Grasp& other) {
      return other.X_WG.matrix() == grasp.X_WG.matrix();
    });
  };
  for (const double shift : {-6.0, 6.0}) {
    CompletedPlannerOptions options;
    options.chance.completed += shift;
    options.min_reported_score = 0;
    const PlanResult all = CompletedPlanner(setup, options).Plan(scene.Input(20));
    ASSERT_EQ(all.grasps.size(), 20u);
    EXPECT_EQ(is_observed(all.grasps.front()), shift < 0);
    EXPECT_TRUE(std::ranges::is_sorted(all.grasps, std::greater(), &Grasp::score));
  }
}

// The network has only one weight, for the width.
TEST(CompletedPlanner, ANetworkRatesTheGraspsOfJaws) {
  constexpr int kWidthInput = 2;
  SuccessNetwork width;
  width.mean = Eigen::VectorXf::Zero(kSuccessInputs);
  width.scale = Eigen::VectorXf::Ones(kSuccessInputs);
  width.layers = {{Eigen::MatrixXf::Zero(1, kSuccessInputs), Eigen::VectorXf::Zero(1)}};
  width.layers.front().weights(0, kWidthInput) = 1;
  const auto network = std::make_shared<SuccessNetwork>(width);
  const Vector3d size_m = Vector3d::Constant(0.04);
  CloudScene scene;
  scene.AddBox(size_m, kSpherePose);
  const ObjectSet objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  GivenShapes shapes({BoxShape(size_m, kSpherePose)});
  const auto plan_with = [&](std::shared_ptr<const Gripper> tool,
                             std::shared_ptr<const SuccessNetwork> network) {
    const std::vector<std::shared_ptr<const Gripper>> tools{std::move(tool)};
    PlannerSetup setup{PlannerSpec(), tools, objects, candidates, {}, 2};
    setup.network = std::move(network);
    setup.shapes = &shapes;
    return CompletedPlanner(setup).Plan(scene.Input(20));
  };
  const PlanResult rated = plan_with(std::make_shared<ParallelJaw>(SmallJaw()), network);
  ASSERT_FALSE(rated.grasps.empty());
  for (const Grasp& grasp : rated.grasps) {
    EXPECT_NEAR(grasp.score, Logistic(20 * grasp.width_m), 1e-6);
  }
  const auto cup = std::make_shared<SuctionCup>();
  const PlanResult by_cup = plan_with(cup, network), without = plan_with(cup, nullptr);
  ASSERT_EQ(by_cup.grasps.size(), without.grasps.size());
  ASSERT_FALSE(by_cup.grasps.empty());
  EXPECT_EQ(by_cup.grasps.front().score, without.grasps.front().score);
}

// Without hidden space, all grasps of the sphere have the same chance.
TEST(CompletedPlanner, LeavesWeakGraspsOut) {
  const CloudScene scene = SphereScene();
  const std::vector<OccupancyShape> shapes{SphereShape(kRadius_m, kSpherePose)};
  const PlanResult all = CompletedPlan(shapes).Of(scene.Input(20));
  ASSERT_FALSE(all.grasps.empty());
  const double best_score = all.grasps.front().score;
  const PlanResult best = CompletedPlan(shapes, nullptr, best_score).Of(scene.Input(20));
  ASSERT_FALSE(best.grasps.empty());
  EXPECT_EQ(best.grasps.front().X_WG.matrix(), all.grasps.front().X_WG.matrix());
  EXPECT_EQ(best.grasps.back().score, best_score);
  const PlanResult none = CompletedPlan(shapes, nullptr, best_score + 0.01).Of(scene.Input(20));
  EXPECT_TRUE(none.grasps.empty());
  EXPECT_GT(none.rejected.at("score too low"), 0);
}

TEST(CompletedPlanner, NeedsASourceOfShapes) {
  const std::vector<std::shared_ptr<const Gripper>> tools{
      std::make_shared<ParallelJaw>(SmallJaw())};
  const ObjectSet objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  EXPECT_THAT(ErrorOf([&] {
                PlannerNamed("completed").make({PlannerSpec(), tools, objects, candidates, {}, 2});
              }),
              HasSubstr("shapes"));
}

}  // namespace
}  // namespace pickbed::tests
