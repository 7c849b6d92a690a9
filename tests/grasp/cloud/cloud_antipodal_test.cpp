#include "grasp/cloud/cloud_antipodal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "grasp/cloud/opposing_faces.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/plan/clearance.h"
#include "grasp/planners/table.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

// A planner with one jaw and no objects.
class CloudPlan {
 public:
  explicit CloudPlan(const PlannerSpec& spec = {}, std::shared_ptr<const Gripper> tool = nullptr)
      : tools_{tool != nullptr ? tool : std::make_shared<ParallelJaw>(SmallJaw())},
        planner_(PlannerSetup{spec, tools_, objects_, candidates_, {}, 2}) {}

  PlanResult Of(const PlannerInput& input) { return planner_.Plan(input); }
  const Gripper& jaw() const { return *tools_.front(); }

 private:
  std::vector<std::shared_ptr<const Gripper>> tools_;
  ObjectSet objects_;
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates_;
  CloudAntipodal planner_;
};

// Angle between two axes, whatever their direction.
double AxisAngle(const Vector3d& a, const Vector3d& b) {
  return std::acos(std::min(1.0, std::abs(a.normalized().dot(b.normalized()))));
}

TEST(CloudAntipodal, HoldsABoxAcrossItsWidthAlongTheFaceNormal) {
  for (const double yaw_rad : {0.0, 0.35, 1.0, 2.2}) {
    CloudScene scene;
    scene.AddBox({0.07, 0.03, 0.04}, OnFloor(0.02, -0.03, 0.04, yaw_rad));
    CloudPlan plan;
    const PlanResult result = plan.Of(scene.Input());
    ASSERT_FALSE(result.grasps.empty()) << yaw_rad;
    const Grasp& best = result.grasps.front();
    const Vector3d normal(-std::sin(yaw_rad), std::cos(yaw_rad), 0);
    EXPECT_LT(AxisAngle(best.X_WG.linear().col(0), normal), 0.09) << yaw_rad;
    EXPECT_NEAR(best.width_m, 0.03, 0.012) << yaw_rad;
    EXPECT_LT((best.X_WG.translation() - Vector3d(0.02, -0.03, 0)).head<2>().norm(), 0.012);
    EXPECT_GT(best.X_WG.translation().z(), 0);
    EXPECT_LT(best.X_WG.translation().z(), 0.036) << "the tips are below the top of the box";
    EXPECT_EQ(best.hypothesis, kNoHypothesis);
    EXPECT_EQ(best.tool, plan.jaw().name);
  }
}

// Each point of the moving hand must be nearer to the camera than the surface in its pixel.
double DeepestBehindSurface_m(const CloudScene& scene, const Gripper& jaw, const Grasp& grasp) {
  constexpr int kSteps = 12;
  double deepest_m = -1;
  for (const AxisAlignedBox& box : HandSweep(jaw, jaw.ApproachOpening_m(grasp.width_m).value())) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        for (int k = 0; k <= kSteps; ++k) {
          const Vector3d share = 2.0 / kSteps * Vector3d(i, j, k) - Vector3d::Ones();
          const Vector3d p_G = box.center + share.cwiseProduct(box.half_size);
          const Vector3d p_C = scene.camera().X_CW() * grasp.X_WG * p_G;
          const Eigen::Vector2d pixel = Project(scene.camera().intrinsics, p_C);
          const int u = static_cast<int>(std::lround(pixel.x()));
          const int v = static_cast<int>(std::lround(pixel.y()));
          if (!scene.frame().depth_m.Contains(u, v)) continue;
          const float seen_m = scene.frame().depth_m(u, v);
          if (seen_m > 0) deepest_m = std::max(deepest_m, p_C.z() - seen_m);
        }
      }
    }
  }
  return deepest_m;
}

CloudScene TallBoxesSeenFromTheSide() {
  CloudScene scene({0, -0.35, 0.5});
  scene.AddBox({0.05, 0.03, 0.07}, OnFloor(-0.05, 0, 0.07, 0.3));
  scene.AddBox({0.03, 0.03, 0.05}, OnFloor(0.06, 0.03, 0.05, 1.2));
  scene.AddBox({0.06, 0.02, 0.02}, OnFloor(0.0, -0.09, 0.02, 0.1));
  return scene;
}

TEST(CloudAntipodal, NoGraspPassesThroughShadow) {
  const CloudScene scene = TallBoxesSeenFromTheSide();
  CloudPlan plan;
  const PlanResult result = plan.Of(scene.Input(200));
  ASSERT_GT(result.grasps.size(), 20u);
  constexpr double kResolution_m = 0.004;  // cells of 2 mm, pixels of 1 mm
  for (const Grasp& grasp : result.grasps) {
    EXPECT_LT(DeepestBehindSurface_m(scene, plan.jaw(), grasp), kResolution_m);
  }
  // The check finds a hand that encloses the tall box along the view, with a finger behind it.
  Grasp hidden;
  hidden.X_WG = FromAbove({-0.05, 0, 0.01}, 0.3 + 0.5 * std::numbers::pi);
  hidden.width_m = 0.03;
  EXPECT_GT(DeepestBehindSurface_m(scene, plan.jaw(), hidden), 0.01);
}

TEST(CloudAntipodal, EqualImagesGiveEqualGrasps) {
  const CloudScene scene = TallBoxesSeenFromTheSide();
  const PlanResult a = CloudPlan().Of(scene.Input(50)), b = CloudPlan().Of(scene.Input(50));
  ASSERT_EQ(a.grasps.size(), b.grasps.size());
  for (size_t i = 0; i < a.grasps.size(); ++i) {
    EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
    EXPECT_EQ(a.grasps[i].score, b.grasps[i].score);
    EXPECT_EQ(a.grasps[i].width_m, b.grasps[i].width_m);
    if (i == 0) continue;
    EXPECT_LE(a.grasps[i].score, a.grasps[i - 1].score);
  }
  EXPECT_EQ(a.rejected, b.rejected);
}

// A world that is moved as a whole moves the grasps.
TEST(CloudAntipodal, GraspsMoveWithTheBin) {
  CloudScene scene;
  scene.AddBox({0.07, 0.03, 0.04}, OnFloor(0.02, -0.03, 0.04, 0.5));
  const Pose X_VW = MakePose(
      Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix(), {0.4, -0.2, 0.1});
  PlannerInput moved = scene.Input();
  moved.X_WC = X_VW * moved.X_WC;
  moved.bin.emplace(BinPlacement{scene.bin(), X_VW});
  const PlanResult here = CloudPlan().Of(scene.Input()), there = CloudPlan().Of(moved);
  ASSERT_FALSE(here.grasps.empty());
  ASSERT_FALSE(there.grasps.empty());
  const Pose expected = X_VW * here.grasps.front().X_WG;
  EXPECT_TRUE(there.grasps.front().X_WG.isApprox(expected, 1e-2));
}

// Only the corners fit between the fingers, and their faces are outside of the friction cone.
TEST(CloudAntipodal, WhatIsWiderThanTheStrokeHasNoGrasp) {
  for (const double yaw_rad : {0.0, 0.2, 0.7}) {
    CloudScene scene;
    scene.AddBox({0.12, 0.11, 0.03}, OnFloor(0, 0, 0.03, yaw_rad));
    EXPECT_TRUE(CloudPlan().Of(scene.Input()).grasps.empty()) << yaw_rad;
  }
}

// 30 % of the rows of a pad, 20 mm wide, must touch the bar. It is so narrow that empty rows are
// near the contact.
TEST(CloudAntipodal, PadsDoNotReachBeyondTheEndOfABar) {
  constexpr double kLength_m = 0.06, kPad_m = 0.02, kCells_m = 0.002;
  CloudScene scene;
  const Pose pose = OnFloor(0, 0, 0.03, 0.3);
  scene.AddBox({0.005, kLength_m, 0.03}, pose);
  const PlanResult result = CloudPlan().Of(scene.Input(1000));
  int checked = 0;
  for (const Grasp& grasp : result.grasps) {
    const Vector3d along = pose.linear().col(1);
    if (AxisAngle(grasp.X_WG.linear().col(1), along) > 0.3) continue;
    const double center_m = std::abs(along.dot(grasp.X_WG.translation() - pose.translation()));
    EXPECT_LT(center_m, 0.5 * kLength_m + 0.5 * kPad_m - 0.3 * kPad_m + kCells_m);
    ++checked;
  }
  EXPECT_GT(checked, 5);
}

// Fingers are 10 mm thick and do not fit into gaps of 6 mm, so only the free ends remain.
TEST(CloudAntipodal, NeighborsBlockTheFingers) {
  CloudScene scene;
  for (const double y_m : {-0.036, 0.0, 0.036}) {
    scene.AddBox({0.06, 0.03, 0.04}, OnFloor(0, y_m, 0.04, 0));
  }
  CloudPlan plan;
  const PlanResult result = plan.Of(scene.Input(50));
  ASSERT_FALSE(result.grasps.empty());
  for (const Grasp& grasp : result.grasps) {
    if (std::abs(grasp.X_WG.translation().y()) > 0.01) continue;  // on an outer box
    EXPECT_LT(AxisAngle(grasp.X_WG.linear().col(0), Vector3d::UnitX()), 0.5);
  }
  EXPECT_GT(result.rejected.at("no room for the fingers"), 0);
}

// A pyramid has no faces that a jaw can press on: they are 45 degrees from the approach.
TEST(CloudAntipodal, SlopingFacesAreOutsideTheFrictionCone) {
  TriangleMesh pyramid;
  pyramid.vertices = {
      {-0.03, -0.03, 0}, {0.03, -0.03, 0}, {0.03, 0.03, 0}, {-0.03, 0.03, 0}, {0, 0, 0.03}};
  pyramid.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 2, 1}, {0, 3, 2}};
  CloudScene scene;
  scene.AddMesh(pyramid, Pose::Identity());
  PlannerSpec spec;
  spec.max_tilt_deg = 0;
  const PlanResult result = CloudPlan(spec).Of(scene.Input());
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_GT(result.rejected.at("faces outside the friction cone"), 0);
}

TEST(CloudAntipodal, ApproachStaysWithinTheTilt) {
  const CloudScene scene = TallBoxesSeenFromTheSide();
  for (const double tilt_deg : {0.0, 20.0}) {
    PlannerSpec spec;
    spec.max_tilt_deg = tilt_deg;
    const PlanResult result = CloudPlan(spec).Of(scene.Input(50));
    ASSERT_FALSE(result.grasps.empty());
    for (const Grasp& grasp : result.grasps) {
      EXPECT_LE(AxisAngle(grasp.X_WG.linear().col(2), Vector3d::UnitZ()),
                tilt_deg * std::numbers::pi / 180 + 1e-6);
    }
  }
}

TEST(CloudAntipodal, EmptyBinHasNoGrasp) {
  EXPECT_TRUE(CloudPlan().Of(CloudScene().Input()).grasps.empty());
}

TEST(CloudAntipodal, RefusesWhatItCannotWorkWith) {
  EXPECT_THAT(ErrorOf([] { CloudPlan({}, std::make_shared<SuctionCup>()); }),
              HasSubstr("needs parallel jaws"));
  CloudScene scene;
  RgbdFrame without_depth;
  const PlannerInput input{without_depth, scene.camera().X_WC(), std::nullopt};
  EXPECT_THAT(ErrorOf([&] { CloudPlan().Of(input); }), HasSubstr("has no depth"));
}

// A box beside a wall. Without a known bin, the wall is an object like the box.
TEST(CloudAntipodal, DoesNotCloseAcrossAWall) {
  CloudScene scene;
  scene.AddBox({0.02, 0.06, 0.045}, OnFloor(0.139, 0, 0.045, 0));
  CloudPlan plan;
  const auto across = [&](const PlanResult& result) {
    return std::ranges::count_if(result.grasps, [&](const Grasp& grasp) {
      return HandMeetsBin(plan.jaw(), *plan.jaw().ApproachOpening_m(grasp.width_m), grasp.X_WG,
                          BinBoxes(scene.bin()), 0);
    });
  };
  PlannerInput input = scene.Input(1000);
  EXPECT_EQ(across(plan.Of(input)), 0);
  input.bin.reset();
  EXPECT_GT(across(plan.Of(input)), 0);
}

}  // namespace
}  // namespace pickbed::tests
