// Measures of grasps on degenerate images, segments and shapes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "grasp/completed/grasp_rater.h"
#include "grasp/grippers/suction_cup.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/degenerate_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A camera 0.8 m above the floor.
const Pose kFromTop = FromAbove({0, 0, 0.8});
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Labels of an image with one segment, all of whose pixels have the same label.
ImageSegments OneSegment(const RgbdFrame& frame, uint16_t label) {
  ImageSegments image{{frame.depth_m.width(), frame.depth_m.height(), label}, {{}}};
  image.segments[0].covered = 0.5;
  image.segments[0].center_C = {0, 0, 0.8};
  return image;
}

std::vector<Grasp> GraspsWithoutWidth() {
  Grasp down, sideways;
  down.X_WG = FromAbove({0, 0, 0.01});
  // The closing direction is vertical.
  sideways.X_WG = down.X_WG * Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY());
  Grasp above = down;
  above.X_WG.translation().z() = 0.9;  // behind the camera
  return {down, sideways, above};
}

TEST(DegenerateRatings, MeasuresAndInputsAreFiniteForAllImages) {
  const ParallelJaw jaw = SmallJaw();
  const SuctionCup cup;
  OccupancyShape full;
  full.size = 2;
  full.cell_m = 0.01;
  full.occupancy.assign(8, 1);
  const std::vector<OccupancyShape> shapes{OccupancyShape(), full};
  const PlanOptions options;
  for (const DepthCase& test : DepthCases()) {
    const RgbdFrame frame = FrameOf(test);
    const PlannerInput input{frame, kFromTop, std::nullopt, {}, {}, 5, 0};
    const ImageSegments image = OneSegment(frame, 1);
    const GraspRater rater(input, Pose::Identity(), image, shapes, options);
    for (const Grasp& grasp : GraspsWithoutWidth()) {
      for (const Gripper* tool :
           {static_cast<const Gripper*>(&jaw), static_cast<const Gripper*>(&cup)}) {
        for (const auto surface : {GraspedSurface::kCompleted, GraspedSurface::kObserved}) {
          const GraspMeasures measures = rater.Measure(grasp, *tool, surface);
          EXPECT_TRUE(std::isfinite(measures.hidden_m) && measures.hidden_m >= 0) << test.name;
          EXPECT_TRUE(std::isfinite(measures.center_offset_m)) << test.name;
          const double chance = SuccessChance().Of(measures);
          EXPECT_TRUE(chance > 0 && chance < 1) << test.name << " " << chance;
          const std::vector<float> inputs = rater.Inputs(grasp, *tool, surface);
          ASSERT_EQ(inputs.size(), size_t{kSuccessInputs});
          EXPECT_TRUE(std::all_of(inputs.begin(), inputs.end(), [](float value) {
            return std::isfinite(value);
          })) << test.name;
        }
      }
    }
  }
}

TEST(DegenerateRatings, WithoutReadingsNothingIsHiddenOrGrasped) {
  const ParallelJaw jaw = SmallJaw();
  for (const DepthCase& test : DepthCases()) {
    if (std::string(test.name) != "no reading" && test.not_finite != kDegeneratePixels) continue;
    const RgbdFrame frame = FrameOf(test);
    const PlannerInput input{frame, kFromTop, std::nullopt, {}, {}, 5, 0};
    const ImageSegments image = OneSegment(frame, 1);
    const Pose X_WG = FromAbove({0, 0, 0.01});
    EXPECT_EQ(GraspedSegment(image, input, jaw, X_WG, 0), nullptr) << test.name;
    const PlanOptions options;
    const GraspRater rater(input, Pose::Identity(), image, {}, options);
    Grasp grasp;
    grasp.X_WG = X_WG;
    EXPECT_EQ(rater.Measure(grasp, jaw, GraspedSurface::kObserved).hidden_m, 0) << test.name;
  }
}

// One reading between the pads decides, if it has a label.
TEST(DegenerateRatings, OneReadingIsASegmentIfItHasALabel) {
  const DepthCase one{"", [](int x, int y) { return x == 160 && y == 120 ? 0.8f : 0.0f; }};
  const RgbdFrame frame = FrameOf(one);
  const PlannerInput input{frame, kFromTop, std::nullopt, {}, {}, 5, 0};
  const Vector3d p_W = kFromTop * BackProject(frame.intrinsics, 160, 120, 0.8f);
  const ParallelJaw jaw = SmallJaw();
  const SuctionCup cup;
  const ImageSegments labelled = OneSegment(frame, 1), background = OneSegment(frame, 0);
  for (const Gripper* tool :
       {static_cast<const Gripper*>(&jaw), static_cast<const Gripper*>(&cup)}) {
    const Pose X_WG = FromAbove(p_W);
    EXPECT_EQ(GraspedSegment(labelled, input, *tool, X_WG, 0), &labelled.segments[0]);
    EXPECT_EQ(GraspedSegment(background, input, *tool, X_WG, 0), nullptr);
    const Pose beside = FromAbove(p_W + Vector3d(0.05, 0.05, 0));
    EXPECT_EQ(GraspedSegment(labelled, input, *tool, beside, 0), nullptr);
  }
}

TEST(DegenerateRatings, CenterOnTheClosingLineHasNoOffset) {
  SegmentMeasures segment;
  segment.center_C = kFromTop.inverse() * Vector3d(0.03, 0, 0.02);
  const auto offset_m = [&](const Pose& X_WG) { return CenterOffset_m(segment, kFromTop, X_WG); };
  EXPECT_NEAR(offset_m(FromAbove({0.03, 0, 0.02})), 0, 1e-12) << "at the center itself";
  EXPECT_NEAR(offset_m(FromAbove({-0.5, 0, 0.02})), 0, 1e-12) << "far along the line";
  EXPECT_NEAR(offset_m(FromAbove({0.03, 0, 0.9})), 0, 1e-12) << "straight above the center";
  // A vertical closing line is a point seen from above.
  const Pose vertical =
      FromAbove({0, 0.04, 0.3}) * Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY());
  EXPECT_NEAR(offset_m(vertical), 0.05, 1e-12);
}

TEST(DegenerateRatings, AShapeWithoutCellsIsNoShape) {
  CloudScene scene;
  scene.AddBox({0.03, 0.03, 0.03}, OnFloor(0, 0, 0.03, 0));
  const PlannerInput input = scene.Input();
  const ImageSegments none;
  OccupancyShape empty;  // its cells have no size
  OccupancyShape free;
  free.size = 1;
  free.cell_m = 0.03;
  free.occupancy = {0};
  const std::vector<OccupancyShape> shapes{empty, free};
  const HandSurroundings with(input, none, shapes), without(input, none, {});
  for (const double opening_m : {0.0, 0.04}) {
    for (const Vector3d& tips_W : {Vector3d(0, 0, 0), Vector3d(0.01, 0.02, 0.03)}) {
      const std::vector<float> values = with.Of(FromAbove(tips_W), opening_m, nullptr);
      EXPECT_EQ(values, without.Of(FromAbove(tips_W), opening_m, nullptr));
      for (const float value : values) ASSERT_TRUE(value >= -1 && value <= 2);
    }
  }
}

TEST(DegenerateRatings, ChancesAreMonotonousUpToTheLimits) {
  const SuccessChance chance;
  GraspMeasures best;
  best.width_m = chance.full_width_m;
  const auto with = [&](double GraspMeasures::*measure, double value) {
    GraspMeasures measures = best;
    measures.*measure = value;
    return chance.Of(measures);
  };
  EXPECT_LT(with(&GraspMeasures::width_m, 0), chance.Of(best));
  EXPECT_EQ(with(&GraspMeasures::width_m, kInfinite), chance.Of(best));
  EXPECT_LT(with(&GraspMeasures::hidden_m, kInfinite), chance.Of(best));
  EXPECT_EQ(with(&GraspMeasures::hidden_m, kInfinite),
            with(&GraspMeasures::hidden_m, chance.full_hidden_m));
  EXPECT_EQ(with(&GraspMeasures::center_offset_m, kInfinite), 0);
}

TEST(DegenerateRatings, InputsOfAGraspWithoutScoreWidthAndOpeningAreFinite) {
  const std::vector<float> surroundings(kSurroundingsValues, 0);
  for (const auto surface : {GraspedSurface::kCompleted, GraspedSurface::kObserved}) {
    GraspMeasures measures;
    measures.surface = surface;
    measures.score = measures.width_m = 0;
    for (const double hidden_m : {0.0, kInfinite}) {
      measures.hidden_m = hidden_m;
      const std::vector<float> inputs = SuccessInputs(measures, 0, 0, surroundings);
      ASSERT_EQ(inputs.size(), size_t{kSuccessInputs});
      for (const float value : inputs) ASSERT_LE(std::abs(value), 10);
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
