#include "grasp/completed/hand_surroundings.h"

#include <gtest/gtest.h>

#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kBox_m = 0.03;
constexpr double kOpening_m = 0.04;
constexpr int kInside = 0, kFinger = 1, kNear = 2, kFar = 3;  // regions along x
constexpr int kPad = 0, kAside = 1;                           // along y
constexpr int kAtTips = 3, kLowest = 5;                       // along z
enum Quantity { kSurface, kOthers, kOccupied };

double MeanOf(const std::vector<float>& values, int x, int y, int z, Quantity quantity) {
  return values[(((x * 3 + y) * 6 + z) * 3 + quantity) * 2];
}
double DifferenceOf(const std::vector<float>& values, int x, int y, int z, Quantity quantity) {
  return values[(((x * 3 + y) * 6 + z) * 3 + quantity) * 2 + 1];
}

// Seen from straight above, so that rays are nearly parallel to the approach.
CloudScene FromAboveScene() { return CloudScene({0, -0.001, 1.5}); }

TEST(HandSurroundings, AFlatFloorIsAtTheHeightOfTheHand) {
  const CloudScene scene = FromAboveScene();
  const PlannerInput input = scene.Input();
  const ImageSegments no_segments;
  const HandSurroundings around(input, no_segments, {});
  constexpr double kHeight_m = 0.012;  // of the finger tips over the floor
  const std::vector<float> values = around.Of(FromAbove({0.02, 0.01, kHeight_m}), kOpening_m, {});
  ASSERT_EQ(values.size(), size_t{kSurroundingsValues});
  // The layer at the tips is symmetric about them. The lowest one is 15 to 30 mm below them.
  EXPECT_NEAR(MeanOf(values, kNear, kAside, kAtTips, kSurface), kHeight_m / 0.02, 0.02);
  EXPECT_NEAR(MeanOf(values, kInside, kPad, kLowest, kSurface), (kHeight_m - 0.0225) / 0.02, 0.02);
  EXPECT_NEAR(MeanOf(values, kFar, kPad, 0, kSurface), 1, 1e-6) << "40 mm above the floor: clamped";
  for (int x = 0; x < 4; ++x) {
    EXPECT_NEAR(DifferenceOf(values, x, kPad, kAtTips, kSurface), 0, 0.03);
    EXPECT_EQ(MeanOf(values, x, kPad, kAtTips, kOthers), 0) << "no segments";
    EXPECT_EQ(MeanOf(values, x, kPad, kAtTips, kOccupied), 0) << "no shapes";
  }
}

// The same hand: a grasp has no front and no back.
TEST(HandSurroundings, AHalfTurnOfTheHandChangesNothing) {
  CloudScene scene;
  scene.AddBox(Vector3d::Constant(kBox_m), OnFloor(0.03, 0.01, kBox_m, 0.4));
  const PlannerInput input = scene.Input();
  const ImageSegments segments = LeftAndRight(scene);
  const std::vector<OccupancyShape> shapes{
      BoxShape(Vector3d::Constant(kBox_m), OnFloor(0.03, 0.01, kBox_m, 0.4))};
  const HandSurroundings around(input, segments, shapes);
  const Vector3d tips_W(0.02, 0.02, 0.01);
  const std::vector<float> a = around.Of(FromAbove(tips_W, 0.3), kOpening_m, nullptr);
  const std::vector<float> b =
      around.Of(FromAbove(tips_W, 0.3 + std::numbers::pi), kOpening_m, nullptr);
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(a[i], b[i], 1e-3) << i;
    largest = std::max(largest, static_cast<double>(a[i]));
  }
  EXPECT_GT(largest, 0.5);
}

TEST(HandSurroundings, SeesASegmentBetweenTheFingersAndAnotherInTheWay) {
  CloudScene scene = FromAboveScene();
  const Pose own = OnFloor(-0.03, 0, kBox_m, 0), other = OnFloor(0.005, 0, kBox_m, 0);
  for (const Pose& pose : {own, other}) scene.AddBox(Vector3d::Constant(kBox_m), pose);
  const PlannerInput input = scene.Input();
  ImageSegments segments = LeftAndRight(scene);
  // The boxes are 5 mm apart.
  ForEachDepthPoint(scene.frame().intrinsics, scene.frame().depth_m,
                    [&](int u, int v, const Vector3d& p_C) {
                      if (segments.labels(u, v) == 0) return;
                      const double x_m = (scene.camera().X_WC() * p_C).x();
                      segments.labels(u, v) = x_m < -0.0125 ? 1 : 2;
                    });
  const std::vector<OccupancyShape> shapes{BoxShape(Vector3d::Constant(kBox_m), own)};
  const HandSurroundings around(input, segments, shapes);
  // 15 mm below the upper faces. The right finger is in the other box.
  const Pose X_WG = FromAbove({-0.03, 0, kBox_m - 0.015});
  const std::vector<float> values = around.Of(X_WG, kOpening_m, &segments.segments[0]);
  EXPECT_EQ(MeanOf(values, kInside, kPad, kAtTips, kOthers), 0);
  EXPECT_GT(DifferenceOf(values, kFinger, kPad, kAtTips, kOthers), 0.5) << "one finger";
  EXPECT_GT(MeanOf(values, kInside, kPad, kAtTips, kOccupied), 0.7);
  EXPECT_EQ(MeanOf(values, kFinger, kPad, kAtTips, kOccupied), 0);
  const std::vector<float> reversed = around.Of(X_WG, kOpening_m, &segments.segments[1]);
  EXPECT_GT(MeanOf(reversed, kInside, kPad, kAtTips, kOthers), 0.7) << "now the other is the own";
}

TEST(HandSurroundings, NothingIsKnownOutsideOfTheImageAndWithoutReadings) {
  const CloudScene scene;
  const PlannerInput seen = scene.Input();
  RgbdFrame holes = scene.frame();
  for (int v = 0; v < holes.depth_m.height(); ++v) {
    for (int u = 0; u < holes.depth_m.width(); ++u) holes.depth_m(u, v) = 0;
  }
  PlannerInput unseen{holes, seen.X_WC, seen.bin};
  const std::vector<float> zeros(kSurroundingsValues, 0);
  EXPECT_EQ(HandSurroundings(seen, {}, {}).Of(FromAbove({9, 0, 0}), kOpening_m, nullptr), zeros);
  EXPECT_EQ(HandSurroundings(seen, {}, {}).Of(FromAbove({0, 0, 9}), kOpening_m, nullptr), zeros)
      << "behind the camera";
  EXPECT_EQ(HandSurroundings(unseen, {}, {}).Of(FromAbove({0, 0, 0}), kOpening_m, nullptr), zeros);
}

}  // namespace
}  // namespace pickbed::tests
