// Planners without poses on degenerate depth images and shapes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/cloud/cloud_suction.h"
#include "grasp/cloud/height_map.h"
#include "grasp/completed/completed_planner.h"
#include "grasp/completed/occupancy_shape.h"
#include "grasp/grippers/suction_cup.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/degenerate_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A camera 0.8 m above the center of the bin.
const Pose kOverBin = FromAbove({0, 0, 0.8});

static_assert(std::is_constructible_v<BinPlacement, const Bin&, Pose>);
static_assert(!std::is_constructible_v<BinPlacement, Bin, Pose>, "the temporary bin would be gone");

PlannerInput InputOf(const RgbdFrame& frame, bool has_bin) {
  PlannerInput input{frame, kOverBin, std::nullopt, {}, {}, 5, 0};
  static const Bin kBin;
  if (has_bin) input.bin.emplace(BinPlacement{kBin, Pose::Identity()});
  return input;
}

void ExpectSound(const PlanResult& plan, const std::string& name) {
  EXPECT_LE(plan.grasps.size(), 5u) << name;
  for (const Grasp& grasp : plan.grasps) {
    EXPECT_TRUE(grasp.X_WG.matrix().allFinite()) << name;
    EXPECT_NEAR(grasp.X_WG.linear().determinant(), 1, 1e-6) << name;
    EXPECT_TRUE(grasp.width_m >= 0 && grasp.width_m < 1) << name << " " << grasp.width_m;
    EXPECT_TRUE(grasp.score >= 0 && grasp.score <= 1) << name << " " << grasp.score;
  }
}

TEST(DegenerateClouds, ObservedSurfacesAndMapsAreFinite) {
  for (const DepthCase& test : DepthCases()) {
    const RgbdFrame frame = FrameOf(test);
    for (const bool has_bin : {false, true}) {
      const PlannerInput input = InputOf(frame, has_bin);
      const ObservedSurface surface = ObserveSurface(frame, input.X_WC, input.bin);
      for (const SurfacePoint& point : surface.points) {
        ASSERT_TRUE(point.p_B.allFinite()) << test.name;
        ASSERT_LT(point.segment, static_cast<int>(surface.segments.size())) << test.name;
      }
      for (const SurfaceSegment& segment : surface.segments) {
        EXPECT_TRUE(segment.center_B.allFinite() && std::isfinite(segment.top_m)) << test.name;
      }
    }
  }
}

class DegeneratePlans : public testing::Test {
 protected:
  PlannerSetup Setup() const { return {PlannerSpec(), tools_, objects_, candidates_, {}, 2}; }
  const std::vector<std::shared_ptr<const Gripper>> tools_{
      std::make_shared<ParallelJaw>(SmallJaw())};
  const ObjectSet objects_;
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates_;
};

TEST_F(DegeneratePlans, GraspsOnTheSurfaceAreFinite) {
  CloudAntipodalOptions few_angles;
  few_angles.angles = 3;
  few_angles.tilts = 1;
  few_angles.tilted_angles = 2;
  CloudAntipodal planner(Setup(), few_angles);
  for (const DepthCase& test : DepthCases()) {
    const RgbdFrame frame = FrameOf(test);
    for (const bool has_bin : {false, true}) {
      ExpectSound(planner.Plan(InputOf(frame, has_bin)), test.name);
    }
  }
  // The cases above have nothing to grasp. A box with some damaged readings has.
  CloudScene scene;
  scene.AddBox({0.07, 0.03, 0.04}, OnFloor(0.02, -0.03, 0.04, 0));
  RgbdFrame damaged = scene.frame();
  for (int y = 0; y < damaged.depth_m.height(); y += 20) {
    for (int x = 0; x < damaged.depth_m.width(); x += 20) {
      damaged.depth_m(x, y) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  const PlannerInput input{
      damaged, scene.camera().X_WC(), BinPlacement{scene.bin(), Pose::Identity()}, {}, {}, 5, 0};
  const PlanResult plan = planner.Plan(input);
  ExpectSound(plan, "damaged box");
  EXPECT_FALSE(plan.grasps.empty());
}

TEST_F(DegeneratePlans, GraspsOfCupsAreFinite) {
  auto cup = std::make_shared<SuctionCup>();
  cup->name = "test cup";
  const std::vector<std::shared_ptr<const Gripper>> cups{cup};
  CloudSuction planner({PlannerSpec(), cups, objects_, candidates_, {}, 2});
  size_t on_a_plane = 0;
  for (const DepthCase& test : DepthCases()) {
    const RgbdFrame frame = FrameOf(test);
    for (const bool has_bin : {false, true}) {
      const PlanResult plan = planner.Plan(InputOf(frame, has_bin));
      ExpectSound(plan, test.name);
      const std::string name = test.name;
      if (!has_bin && name == "constant depth") on_a_plane = plan.grasps.size();
      if (name == "no reading" || name == "one reading" || name == "a row" || name == "a column" ||
          test.not_finite == kDegeneratePixels) {
        EXPECT_TRUE(plan.grasps.empty()) << name << ": a lip needs an area";
      }
    }
  }
  EXPECT_GT(on_a_plane, 0u) << "a lip seals on a plane";
}

TEST_F(DegeneratePlans, AnImageWithoutReadingsHasNoGrasp) {
  CloudAntipodal planner(Setup());
  for (const DepthCase& test : DepthCases()) {
    if (std::string(test.name) != "no reading" && test.not_finite != kDegeneratePixels) continue;
    EXPECT_TRUE(planner.Plan(InputOf(FrameOf(test), true)).grasps.empty()) << test.name;
  }
}

// Shapes without matter, full ones, single cells, plates and lines of cells.
std::vector<OccupancyShape> DegenerateShapes() {
  const Pose at = OnFloor(0, 0, 0.04, 0);
  const auto shape = [&](auto probability) { return ShapeOfBody(0.06, 12, at, probability); };
  OccupancyShape one;
  one.size = 1;
  one.cell_m = 0.03;
  one.occupancy = {1};
  const double cell_m = 0.06 / 12;
  return {OccupancyShape(),
          one,
          shape([](const Vector3d&) { return 0.0; }),
          shape([](const Vector3d&) { return 1.0; }),
          shape([](const Vector3d&) { return 0.45; }),  // exactly at the grasped level
          shape([&](const Vector3d& p) { return p.norm() < cell_m ? 1.0 : 0.0; }),
          shape([&](const Vector3d& p) { return std::abs(p.x()) < cell_m ? 1.0 : 0.0; }),
          shape([&](const Vector3d& p) { return p.head<2>().norm() < cell_m ? 1.0 : 0.0; }),
          shape([&](const Vector3d& p) {
            return (std::lround(p.sum() / cell_m) % 2 == 0) ? 1.0 : 0.0;
          })};
}

TEST(DegenerateShapes, SurfacesAndShellsAreFinite) {
  for (const OccupancyShape& shape : DegenerateShapes()) {
    for (const OccupancyShape& some : {shape, Smoothed(shape)}) {
      ASSERT_EQ(some.occupancy.size(), shape.occupancy.size());
      for (const float p : some.occupancy) ASSERT_TRUE(p >= 0 && p <= 1.0001f);
      for (const double level : {0.01, 0.45, 0.99}) {
        const TriangleMesh mesh = SurfaceOf(some, level);
        for (const Vector3d& p : mesh.vertices) ASSERT_TRUE(p.allFinite());
        for (const Eigen::Vector3i& t : mesh.triangles) {
          ASSERT_GE(t.minCoeff(), 0);
          ASSERT_LT(t.maxCoeff(), static_cast<int>(mesh.vertices.size()));
        }
        for (const Vector3d& p : ShellOf(some, level)) ASSERT_TRUE(p.allFinite());
      }
    }
  }
}

TEST_F(DegeneratePlans, GraspsOnCompletedShapesAreFinite) {
  const CloudScene scene;  // an empty bin
  size_t grasps = 0;
  for (const OccupancyShape& shape : DegenerateShapes()) {
    GivenShapes source({shape});
    PlannerSetup setup = Setup();
    setup.shapes = &source;
    setup.spec.rehearsals = 5;
    CompletedPlannerOptions options;
    options.grasps_observed = false;
    CompletedPlanner planner(setup, options);
    const PlanResult plan = planner.Plan(scene.Input());
    ExpectSound(plan, std::to_string(shape.size));
    grasps += plan.grasps.size();
  }
  EXPECT_GT(grasps, 0u) << "some shape must have a grasp to check";
}

}  // namespace
}  // namespace pickbed::tests
